#pragma once

#include <cstddef>

namespace tetrakis {

/// The first touch of fresh memory costs as much as most work on it, so the process keeps large blocks that its runs
/// (tessellations, refinements, hierarchies) have freed for those to come. Blocks that are kept count for the process's
/// resident memory; results that callers own are not among them until they are destroyed.
/// @param bytes  how many are kept at most, the latest first (default_freed_memory() unless this is called);
///               0: none. What is above is given back at once
/// Any thread may call it at any time. Linux only; elsewhere oneTBB's allocator decides.
void keep_freed_memory(std::size_t bytes);

/// What that is unless it is set, in bytes: a 64th of the machine's memory, 512 MiB at most.
std::size_t default_freed_memory();

}  // namespace tetrakis
