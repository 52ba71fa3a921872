#pragma once

#include "random_mesh.hpp"

#include "../../hier/base/error.hpp"
#include "../../hier/mesh/control_mesh.hpp"
#include "../../hier/mesh/mesh_check.hpp"

#include <doctest/doctest.h>

#include <cstdint>
#include <random>
#include <string>
#include <vector>

namespace tetrakis::test {

inline std::vector<Vec3d> random_points(std::uint32_t count, std::mt19937_64& random) {
    std::uniform_real_distribution<double> coordinate(-1.0, 1.0);
    std::vector<Vec3d> points(count);
    for (Vec3d& p : points) p = {coordinate(random), coordinate(random), coordinate(random)};
    return points;
}

inline bool contains(const std::string& text, const std::string& part) { return text.find(part) != std::string::npos; }

/// The error that `call` throws; fails the test if it throws none.
template <class Call>
Error error_of(Call&& call) {
    try {
        call();
    } catch (const Error& error) {
        return error;
    }
    FAIL("no error was thrown");
    return Error(ErrorCode::unsupported, "");
}

inline RunContext with_thread_count(int threads) {
    RunContext context;
    context.threads = threads;
    return context;
}

}  // namespace tetrakis::test
