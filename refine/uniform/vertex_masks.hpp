#pragma once

#include "../../schemes/core/ring_mask.hpp"

#include <array>
#include <cstdint>

namespace tetrakis::detail {

/// A scheme's masks by valence: those of valences 1 to 63 are kept, as to find one takes divisions or a cosine.
class VertexMasks {
  public:
    explicit VertexMasks(RingMask (*of)(int valence)) : of_(of) {
        for (int n = 1; n < static_cast<int>(kept_.size()); ++n) kept_[n] = of(n);
    }
    RingMask operator()(std::uint32_t valence) const {
        return valence < kept_.size() ? kept_[valence] : of_(static_cast<int>(valence));
    }

  private:
    RingMask (*of_)(int);
    std::array<RingMask, 64> kept_{};
};

}  // namespace tetrakis::detail
