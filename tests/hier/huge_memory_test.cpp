#include "../../hier/base/huge_memory.hpp"
#include "../../hier/base/freed_memory.hpp"
#include "../../hier/base/huge_buffer.hpp"
#include "../../hier/base/parallel.hpp"

#include <doctest/doctest.h>

#include <cstdint>
#include <cstring>
#include <fstream>
#include <random>
#include <string>
#include <vector>

#if defined(__linux__)
#    include <sys/mman.h>
#endif

using namespace tetrakis;

namespace {

struct Block {
    unsigned char* data = nullptr;
    std::size_t bytes = 0;
    unsigned char mark = 0;

    /// The number of bytes that do not say what was written, looked at here and there.
    std::size_t wrong(std::size_t size) const {
        std::size_t count = 0;
        for (std::size_t i = 0; i < size; i += 509) count += data[i] != mark;
        return count + (size > 0 && data[size - 1] != mark);
    }
};

/// Blocks that grow and are freed in random order, of sizes from bytes to several huge pages.
std::size_t mistakes_of_random_blocks(std::uint64_t seed) {
    std::mt19937_64 random(seed);
    std::vector<Block> blocks(8);
    std::size_t mistakes = 0;
    for (int step = 0; step < 150; ++step) {
        Block& b = blocks[random() % blocks.size()];
        if (random() % 4 == 0) {
            mistakes += b.wrong(b.bytes);
            detail::free_memory(b.data, b.bytes);
            b = {};
            continue;
        }
        const std::size_t bytes = b.bytes + (std::size_t{1} << random() % 22) + random() % 1000;
        void* const grown = detail::grow_memory(b.data, b.bytes, bytes);
        if (grown == nullptr) return mistakes + 1;
        b.data = static_cast<unsigned char*>(grown);
        mistakes += b.wrong(b.bytes);
        b.bytes = bytes;
        b.mark = static_cast<unsigned char>(random());
        std::memset(grown, b.mark, bytes);
    }
    for (const Block& b : blocks) {
        mistakes += b.wrong(b.bytes);
        detail::free_memory(b.data, b.bytes);
    }
    return mistakes;
}

}  // namespace

TEST_CASE("memory keeps its contents as it grows, whatever was freed before, in any thread") {
    for (const std::size_t kept : {std::size_t{0}, std::size_t{4} << 20, default_freed_memory()}) {
        CAPTURE(kept);
        keep_freed_memory(kept);
        std::vector<std::size_t> mistakes(8, 1);
        for_each_index(
            8, [&](std::uint32_t i) { mistakes[i] = mistakes_of_random_blocks(i); }, 1);
        for (const std::size_t count : mistakes) CHECK(count == 0);
    }
}

#if defined(__linux__) && !defined(__SANITIZE_ADDRESS__)
TEST_CASE("a large block that was freed is there for the next run, unless nothing is to be kept") {
    for (const std::size_t bytes : {std::size_t{1500} << 10, std::size_t{9} << 20}) {
        CAPTURE(bytes);
        keep_freed_memory(0);
        keep_freed_memory(std::size_t{16} << 20);
        void* const first = detail::grow_memory(nullptr, 0, bytes);
        std::memset(first, 1, bytes);
        detail::free_memory(first, bytes);
        void* const second = detail::grow_memory(nullptr, 0, bytes - 1000);
        CHECK(second == first);
        CHECK(static_cast<unsigned char*>(second)[bytes / 2] == 1);  // the very pages
        detail::free_memory(second, bytes - 1000);
        keep_freed_memory(0);
        keep_freed_memory(std::size_t{16} << 20);
        void* const third = detail::grow_memory(nullptr, 0, bytes);
        CHECK(static_cast<unsigned char*>(third)[bytes / 2] == 0);
        detail::free_memory(third, bytes);
    }
    keep_freed_memory(default_freed_memory());
}

TEST_CASE("a large block grows into the pages of others that were freed, of any size") {
    constexpr std::size_t k_mega = std::size_t{1} << 20;
    keep_freed_memory(0);
    keep_freed_memory(64 * k_mega);
    const auto block = [](std::size_t bytes, int mark) {
        void* const data = detail::grow_memory(nullptr, 0, bytes);
        std::memset(data, mark, bytes);
        return data;
    };
    // Three blocks that are not neighbours, and one between them that stays.
    void* const first = block(10 * k_mega, 1);
    void* const stays = block(6 * k_mega, 2);
    void* const second = block(14 * k_mega, 3);
    detail::free_memory(first, 10 * k_mega);
    detail::free_memory(second, 14 * k_mega);
    auto* data = static_cast<unsigned char*>(block(4 * k_mega, 5));
    std::size_t size = 4 * k_mega;
    for (const std::size_t next : {6 * k_mega, 12 * k_mega, 22 * k_mega, 40 * k_mega}) {
        data = static_cast<unsigned char*>(detail::grow_memory(data, size, next));
        REQUIRE(data != nullptr);
        for (std::size_t i = 0; i < size; i += 4096) REQUIRE(data[i] == 5);
        // What came is the freed pages as long as there are any (24 MiB), and the system's zeros then.
        for (std::size_t i = size; i < next; i += 4096) CHECK((data[i] != 0) == (i < 24 * k_mega));
        std::memset(data, 5, next);
        size = next;
    }
    for (std::size_t i = 0; i < 6 * k_mega; i += 4096) REQUIRE(static_cast<unsigned char*>(stays)[i] == 2);
    detail::free_memory(stays, 6 * k_mega);
    detail::free_memory(data, size);
    keep_freed_memory(default_freed_memory());
}

namespace {

/// Takes all mappings that the system lets a process have but `left` or one more.
class FewMappings {
  public:
    explicit FewMappings(std::size_t left) {
        std::size_t most = 65530;
        std::ifstream("/proc/sys/vm/max_map_count") >> most;
        std::ifstream maps("/proc/self/maps");
        std::size_t count = 1;
        for (std::string line; std::getline(maps, line);) ++count;
        if (most > k_most) return;
        bytes_ = 2 * k_page * most;
        begin_ =
            static_cast<char*>(mmap(nullptr, bytes_, PROT_NONE, MAP_PRIVATE | MAP_ANONYMOUS | MAP_NORESERVE, -1, 0));
        // A page that differs from those beside it makes two mappings more.
        char* page = begin_;
        for (; count + 2 + left <= most; count += 2, page += 2 * k_page)
            if (mprotect(page + k_page, k_page, PROT_READ) != 0) break;
        taken_ = page > begin_;
    }
    FewMappings(const FewMappings&) = delete;
    FewMappings& operator=(const FewMappings&) = delete;
    ~FewMappings() {
        if (begin_ != nullptr) munmap(begin_, bytes_);
    }
    bool taken() const { return taken_; }

  private:
    static constexpr std::size_t k_page = 4096, k_most = 1'000'000;
    char* begin_ = nullptr;
    std::size_t bytes_ = 0;
    bool taken_ = false;
};

}  // namespace

TEST_CASE("a block grows, or stays what it is, where the system has hardly any mappings left") {
    constexpr std::size_t k_mega = std::size_t{1} << 20;
    for (const std::size_t kept : {std::size_t{0}, 16 * k_mega}) {
        for (std::size_t left = 3; left < 10; ++left) {
            CAPTURE(kept);
            CAPTURE(left);
            keep_freed_memory(0);
            keep_freed_memory(kept);
            constexpr std::size_t k_bytes = 12 * k_mega;
            auto* data = static_cast<unsigned char*>(detail::grow_memory(nullptr, 0, k_bytes));
            std::memset(data, 7, k_bytes);
            if (kept > 0) {
                void* const freed = detail::grow_memory(nullptr, 0, kept);
                std::memset(freed, 1, kept);
                detail::free_memory(freed, kept);
            }
            std::size_t size = k_bytes, wrong = 0;
            bool taken = false;
            {
                const FewMappings few(left);
                taken = few.taken();
                void* const grown = detail::grow_memory(data, k_bytes, 2 * k_bytes);
                if (grown != nullptr) {
                    data = static_cast<unsigned char*>(grown);
                    size = 2 * k_bytes;
                }
                for (std::size_t i = 0; i < k_bytes; i += 4096) wrong += data[i] != 7;
            }
            CHECK(wrong == 0);
            detail::free_memory(data, size);
            if (!taken) MESSAGE("skipped: this system lets a process have too many mappings to take them all");
        }
    }
    keep_freed_memory(default_freed_memory());
}
#endif

TEST_CASE("buffers begin at a cache line") {
    for (const std::size_t size : {1, 100, 50'000, 3'000'000}) {
        detail::HugeBuffer<float> buffer;
        float* const data = buffer.reserve(size);
        CHECK(reinterpret_cast<std::uintptr_t>(data) % 64 == 0);
        data[0] = data[size - 1] = 1.0f;
        CHECK(buffer.reserve(size / 2) == data);
    }
}
