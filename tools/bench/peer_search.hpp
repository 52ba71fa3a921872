#pragma once

#include "limit_judge.hpp"
#include "peer_osd.hpp"

#include <filesystem>
#include <functional>
#include <string>
#include <string_view>
#include <vector>

namespace tetrakis::bench {

/// The best that one way of using Bfr does at one tolerance.
struct PeerResult {
    std::string model;
    double tolerance = 0;  ///< relative to the diagonal of the limit's bounding box, as are the errors
    std::string method;    ///< "bfr-rate" or "bfr-adapt"
    bool met = false;
    std::uint64_t triangles = 0;
    double ms = 0, ms_normals = 0;  ///< median of 5, control arrays to indexed triangles; and with normals
    double error = 0;               ///< limit to mesh
    double backward = 0;            ///< mesh to limit
    std::string parameter{};        ///< "R=6 s=2", "k=3.59 s=2"
};

/// The least of the rates 1, 2, 3, 4, 6, 8, 12, 16, 24, 32 that meets the tolerance, within 5 million triangles.
PeerResult best_uniform_rate(std::string_view model, const ControlMeshData& data, SchemeKind scheme,
                             const LimitJudge& judge, double tolerance);
/// The least factor k (to one per cent) with which the rates per edge meet the tolerance.
PeerResult best_adaptive_rates(std::string_view model, const ControlMeshData& data, SchemeKind scheme,
                               const LimitJudge& judge, double tolerance);

/// What makes a known result's mesh, with normals, once more: times of one table must come from one run. It keeps
/// `data`.
std::function<PeerMesh()> peer_work(const PeerResult& result, const ControlMeshData& data, SchemeKind scheme,
                                    const LimitJudge& judge);

/// Points and triangles of a peer's mesh for the judge.
std::pair<std::vector<Vec3d>, std::vector<std::array<std::uint32_t, 3>>> in_double(const PeerMesh& mesh);

/// Results kept in a text file from run to run, one per line; they depend on the models and OpenSubdiv alone, but the
/// times are the machine's.
class PeerResults {
  public:
    explicit PeerResults(std::filesystem::path file = {});  ///< empty: not kept
    const PeerResult* find(std::string_view model, double tolerance, std::string_view method) const;
    void add(const PeerResult& result);

  private:
    std::filesystem::path file_;
    std::vector<PeerResult> results_;
};

}  // namespace tetrakis::bench
