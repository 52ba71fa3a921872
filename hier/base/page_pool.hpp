#pragma once

#include <cstddef>

// Under AddressSanitizer everything comes from the system's allocator, which it watches.
#if defined(__linux__) && !defined(__SANITIZE_ADDRESS__)
#    define TETRAKIS_MAPS_PAGES

namespace tetrakis::detail {

/// Blocks of pages of their own, for memory from k_mapped bytes on. What is freed is kept for the blocks to come, the
/// latest up to a limit, because the first touch of a page costs more than most work on it. Kept pages find their way
/// into blocks of any size: a large block is put together from those of others by the page tables.
namespace page_pool {

inline constexpr std::size_t k_huge = std::size_t{2} << 20;  // a huge page of x86-64, and of arm64 with pages of 4 KiB
inline constexpr std::size_t k_large = 2 * k_huge;           // blocks from here on are on huge pages
inline constexpr std::size_t k_mapped = std::size_t{1} << 20;  // below, the parts of pages at the ends outweigh

/// The size of the block for so many bytes, k_mapped at least. There are few sizes, so that kept blocks fit again.
std::size_t block_size(std::size_t bytes);
/// A block of a block size with any contents; nullptr: there is no room.
void* take(std::size_t bytes);
/// A block from k_large on in a larger one, with its contents; nullptr, with the block as it was: there is no room.
void* extend(void* data, std::size_t old_bytes, std::size_t bytes);
/// Frees a block.
void put(void* data, std::size_t bytes) noexcept;
/// How much is kept, from now on.
void keep_at_most(std::size_t bytes) noexcept;
/// Gives all that is kept back to the system. Returns whether there was any.
bool give_back() noexcept;

}  // namespace page_pool

}  // namespace tetrakis::detail

#endif
