#include "interrupt.hpp"

#include "exit_code.hpp"

#include <unistd.h>

#include <csignal>
#include <initializer_list>

namespace tetrakis::cli {
namespace {

volatile std::sig_atomic_t interrupt_flag = 0, end_at_once = 0;

extern "C" void take_interrupt(int) {
    if (end_at_once != 0 || interrupt_flag != 0) _exit(static_cast<int>(ExitCode::cancelled));
    interrupt_flag = 1;
}

}  // namespace

void catch_interrupts() {
    end_at_once = 0;
    std::signal(SIGXFSZ, SIG_IGN);  // a file that grows too large is then an error of its write
    for (const int signal : {SIGINT, SIGTERM}) {
        struct sigaction action = {};
        // A program started in the background by a shell without job control ignores SIGINT; that stays so.
        if (sigaction(signal, nullptr, &action) == 0 && action.sa_handler == SIG_IGN) continue;
        action = {};
        action.sa_handler = take_interrupt;
        action.sa_flags = SA_RESTART;
        sigemptyset(&action.sa_mask);
        sigaction(signal, &action, nullptr);
    }
}

void let_interrupts_end() { end_at_once = 1; }

bool interrupted() noexcept { return interrupt_flag != 0; }

}  // namespace tetrakis::cli
