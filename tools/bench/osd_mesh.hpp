#pragma once

#include "../../hier/mesh/control_mesh.hpp"
#include "../../schemes/core/scheme_kind.hpp"

#include <opensubdiv/far/topologyRefiner.h>

#include <memory>

namespace tetrakis::bench {

/// OpenSubdiv's own representation of a control mesh, tags and rules included; unrefined, as Bfr takes it.
std::unique_ptr<OpenSubdiv::Far::TopologyRefiner> make_refiner(const ControlMeshData& data, SchemeKind scheme);

}  // namespace tetrakis::bench
