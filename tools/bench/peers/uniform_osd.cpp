#include "../../../schemes/core/stencil_table.hpp"
#include "../../../tests/kit/osd_refiner.hpp"
#include "uniform_peers.hpp"

#include <opensubdiv/far/stencilTableFactory.h>
#include <opensubdiv/osd/cpuEvaluator.h>

#include <vector>

namespace tetrakis::bench {

namespace osd = OpenSubdiv;

std::function<std::uint64_t()> far_uniform(const UniformTask& task) {
    return [task]() -> std::uint64_t {
        const test::FarLevel level(task.data, *scheme_from_name(task.scheme), task.levels, task.limit);
        if (!task.limit) return level.points.size();
        std::vector<test::FarPoint> limits(level.points.size()), du(limits.size()), dv(limits.size());
        osd::Far::PrimvarRefinerReal<double>(*level.refiner).Limit(level.points, limits, du, dv);
        return limits.size();
    };
}

std::function<std::uint64_t()> stencil_evaluation(const UniformTask& task) {
    struct Table {
        std::unique_ptr<const osd::Far::StencilTable> stencils;
        std::vector<float> from, to;
    };
    auto table = std::make_shared<Table>();
    const auto refiner = test::osd_refiner(task.data, *scheme_from_name(task.scheme), false);
    refiner->RefineUniform(osd::Far::TopologyRefiner::UniformOptions(task.levels));
    osd::Far::StencilTableFactory::Options options;
    options.generateIntermediateLevels = false;
    options.generateOffsets = true;
    table->stencils.reset(osd::Far::StencilTableFactory::Create(*refiner, options));
    for (const Vec3d& p : task.data.positions)
        for (int i = 0; i < 3; ++i) table->from.push_back(static_cast<float>(p[i]));
    const auto count = static_cast<std::uint64_t>(table->stencils->GetNumStencils());
    table->to.resize(3 * count);
    return [table, count] {
        const osd::Osd::BufferDescriptor layout(0, 3, 3);
        osd::Osd::CpuEvaluator::EvalStencils(table->from.data(), layout, table->to.data(), layout,
                                             table->stencils->GetSizes().data(), table->stencils->GetOffsets().data(),
                                             table->stencils->GetControlIndices().data(),
                                             table->stencils->GetWeights().data(), 0, static_cast<int>(count));
        return count;
    };
}

}  // namespace tetrakis::bench
