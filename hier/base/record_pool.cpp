#include "record_pool.hpp"

#include "pool_memory.hpp"

#include <oneapi/tbb/enumerable_thread_specific.h>

#include <cstddef>
#include <vector>

namespace tetrakis::detail {

struct RecordPool::Threads {
    struct alignas(std::max_align_t) Unit {
        std::byte bytes[alignof(std::max_align_t)];
    };
    // 32 KiB: a hundred stars, and little to waste for a small mesh.
    static constexpr std::size_t k_block = 2048;

    struct Blocks {
        std::vector<PoolVector<Unit>> blocks;
        Unit* next = nullptr;
        std::size_t left = 0;
    };
    oneapi::tbb::enumerable_thread_specific<Blocks> blocks;
};

RecordPool::RecordPool() : threads_(std::make_unique<Threads>()) {}
RecordPool::~RecordPool() = default;

void* RecordPool::allocate(std::size_t bytes) {
    using Unit = Threads::Unit;
    Threads::Blocks& own = threads_->blocks.local();
    const std::size_t units = (bytes + sizeof(Unit) - 1) / sizeof(Unit);
    if (units > own.left) {
        const std::size_t size = units > Threads::k_block ? units : Threads::k_block;
        PoolVector<Unit>& block = own.blocks.emplace_back();
        block.reserve(size);  // without a first touch
        own.next = block.data();
        own.left = size;
    }
    Unit* const out = own.next;
    own.next += units;
    own.left -= units;
    return out;
}

}  // namespace tetrakis::detail
