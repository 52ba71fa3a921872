#include "commands.hpp"

#include "../../hier/base/memory.hpp"

#if defined(__GLIBC__)
#    include <malloc.h>
#endif

namespace {

/// keep_freed_memory() for malloc(), which by default often returns pages to the system and then needs new ones.
void keep_freed_heap() {
#if defined(__GLIBC__)
    constexpr int k_own_mapping = 4 << 20;  // bytes from which a block gets a mapping of its own
    mallopt(M_MMAP_THRESHOLD, k_own_mapping);
    mallopt(M_TRIM_THRESHOLD, static_cast<int>(tetrakis::default_freed_memory()));
#endif
}

}  // namespace

int main(int argc, char** argv) {
    using namespace tetrakis::cli;
    keep_freed_heap();
    Program program(
        "tetrakis", "tetrakis: adaptive tessellation of subdivision surfaces to a stated tolerance",
        "Exit codes: 0 done, 1 failure at run time, 2 usage, 3 bad input, 4 tolerance not reached (the best result is\n"
        "written), 130 cancelled. Each command explains itself: tetrakis tessellate --help");
    for (const auto& add :
         {add_info_command, add_tessellate_command, add_refine_command, add_terrain_command, add_tiles_command,
          add_lod_command, add_compare_command, add_render_command, add_scheme_command, add_schemes_command})
        add(program.line());
    return program.run(argc, argv);
}
