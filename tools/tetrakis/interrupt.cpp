#include "interrupt.hpp"

#include <csignal>
#include <initializer_list>

namespace tetrakis::cli {
namespace {

volatile std::sig_atomic_t interrupt_flag = 0;

extern "C" void set_interrupt_flag(int) { interrupt_flag = 1; }

}  // namespace

void catch_interrupts() {
    std::signal(SIGXFSZ, SIG_IGN);  // a file that grows too large is then an error of its write
    for (const int signal : {SIGINT, SIGTERM}) {
        struct sigaction action = {};
        // A program started in the background by a shell without job control ignores SIGINT; that stays so.
        if (sigaction(signal, nullptr, &action) == 0 && action.sa_handler == SIG_IGN) continue;
        action = {};
        action.sa_handler = set_interrupt_flag;
        action.sa_flags = static_cast<int>(SA_RESETHAND | SA_RESTART);
        sigemptyset(&action.sa_mask);
        sigaction(signal, &action, nullptr);
    }
}

void let_interrupts_end() {
    for (const int signal : {SIGINT, SIGTERM}) {
        struct sigaction action = {};
        if (sigaction(signal, nullptr, &action) == 0 && action.sa_handler == set_interrupt_flag)
            std::signal(signal, SIG_DFL);
    }
}

bool interrupted() noexcept { return interrupt_flag != 0; }

}  // namespace tetrakis::cli
