#pragma once

#include <cstdint>
#include <unordered_map>
#include <vector>

namespace tetrakis::detail {

/// Numbers keys from 0 on in the order in which they are first seen. A few are looked through, more are hashed.
class FirstSeen {
  public:
    static constexpr std::uint32_t none = 0xFFFF'FFFFu;

    FirstSeen() { keys_.reserve(k_few); }

    /// The key's number; a new one where it was not seen yet.
    std::uint32_t number(std::uint32_t key) {
        const std::uint32_t known = find(key);
        if (known != none) return known;
        const auto fresh = static_cast<std::uint32_t>(keys_.size());
        keys_.push_back(key);
        if (keys_.size() == k_few)
            for (std::uint32_t i = 0; i < fresh; ++i) numbers_.emplace(keys_[i], i);
        if (keys_.size() >= k_few) numbers_.emplace(key, fresh);
        return fresh;
    }
    /// Its number, or none.
    std::uint32_t find(std::uint32_t key) const {
        if (keys_.size() >= k_few) {
            const auto found = numbers_.find(key);
            return found == numbers_.end() ? none : found->second;
        }
        for (std::uint32_t i = 0; i < keys_.size(); ++i)
            if (keys_[i] == key) return i;
        return none;
    }

  private:
    static constexpr std::size_t k_few = 64;
    std::vector<std::uint32_t> keys_;
    std::unordered_map<std::uint32_t, std::uint32_t> numbers_;
};

}  // namespace tetrakis::detail
