// AddressSanitizer has functions of its own for these.
#if !defined(__SANITIZE_ADDRESS__)

#    include "../kit/hierarchy_helpers.hpp"

#    include "../../hier/base/error.hpp"
#    include "../../refine/adaptive/hierarchy.hpp"

#    include <doctest/doctest.h>

#    include <atomic>
#    include <cstdlib>
#    include <new>

// The whole program's: fails once when as many calls as asked for have been made.
namespace {

std::atomic<long> calls_left{-1};
std::atomic<bool> has_failed{false};

bool fails() {
    if (calls_left.load() < 0 || calls_left.fetch_sub(1) != 0) return false;
    return has_failed = true;
}

}  // namespace

void* operator new(std::size_t bytes) {
    void* const memory = fails() ? nullptr : std::malloc(bytes > 0 ? bytes : 1);
    if (memory == nullptr) throw std::bad_alloc();
    return memory;
}
void* operator new[](std::size_t bytes) { return operator new(bytes); }
void operator delete(void* memory) noexcept { std::free(memory); }
void operator delete[](void* memory) noexcept { std::free(memory); }
void operator delete(void* memory, std::size_t) noexcept { std::free(memory); }
void operator delete[](void* memory, std::size_t) noexcept { std::free(memory); }

using namespace tetrakis;
using test::Random;

TEST_SUITE_BEGIN("refine");

TEST_CASE("a change that runs out of memory leaves the hierarchy as it was, or lost and said to be") {
    for (const std::string_view scheme : {"catmull-clark", "loop", "doo-sabin", "sqrt3"}) {
        CAPTURE(scheme);
        const ControlMesh mesh = test::hierarchy_mesh(scheme, 4);
        int unchanged = 0, lost = 0;
        for (const bool refines : {true, false})
            for (long calls = 0;; ++calls) {
                CAPTURE(refines);
                CAPTURE(calls);
                Hierarchy h = make_hierarchy(mesh, scheme);
                Random random(7);
                h.stamp();
                test::random_changes(h, 8, 4, random, [] {});
                const std::vector<LeafHandle> all = test::leaves_of(h), some = test::random_subset(all, 0.3, random);
                const std::vector<std::byte> before = h.saved();
                has_failed = false;
                calls_left = calls;
                try {
                    refines ? h.refine(some) : h.coarsen(all);
                    calls_left = -1;
                } catch (const std::bad_alloc&) {
                    calls_left = -1;
                    if (const auto fault = h.check()) {
                        ++lost;
                        REQUIRE(fault->find("memory") != std::string::npos);
                        REQUIRE(!h.is_leaf(all.front()));
                        REQUIRE_THROWS_AS(h.leaves(), Error);
                        REQUIRE_THROWS_AS(h.refine(some), Error);
                        REQUIRE_THROWS_AS(h.to_mesh(), Error);
                        h.load(before);
                    } else {
                        ++unchanged;
                        REQUIRE(h.is_leaf(all.front()));
                    }
                    REQUIRE(h.saved() == before);
                }
                REQUIRE(h.check().value_or("") == "");
                if (!has_failed) break;
            }
        CHECK(unchanged > 0);
        CHECK(lost > 0);
    }
}

TEST_SUITE_END();

#endif
