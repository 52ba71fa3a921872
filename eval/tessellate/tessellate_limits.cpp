#include "tessellate_limits.hpp"

#include "../../refine/uniform/refine.hpp"
#include "../../schemes/rules/linear.hpp"
#include "../bounds/dual_bound.hpp"
#include "../distance/surface_family.hpp"
#include "../estimate/linear_bound.hpp"
#include "../estimate/mask_norm_bound.hpp"

#include <string>
#include <string_view>

namespace tetrakis {

namespace {

void check_scheme(const TessellateOptions& options) {
    const SchemeInfo& scheme = options.scheme.info();
    const std::string name(scheme.name);
    const SchemeSupport support = scheme_support(options.scheme, options.rules);
    if (options.target || options.displacement)
        throw Error(ErrorCode::unsupported,
                    std::string(options.target ? "a target" : "a displacement") +
                        " needs exact points and normals all over the surface, which " + name +
                        " has at its vertices only; use catmull-clark or loop with their plain rules "
                        "and without corner angles");
    if (options.estimator == EstimatorKind::certified && !support.certified)
        throw Error(
            ErrorCode::unsupported,
            "there is no certified bound for " + name +
                ": its limit is known at points alone; use the measured estimator, or one of catmull-clark, loop, "
                "tuned-loop, butterfly, modified-butterfly, kobbelt, 4-8, averaging in an even number of steps, "
                "doo-sabin, doo-sabin-cc, midedge, midedge-simplest, bilinear, midpoint");
}

}  // namespace

SchemeSupport scheme_support(const SchemeChoice& scheme, const RuleOptions& rules) {
    SchemeSupport support;
    const SchemeInfo& info = scheme.info();
    support.adaptive = info.refinement != Refinement::honeycomb;
    support.patches = detail::has_plain_rules(info, rules);
    support.certified =
        support.patches || is_linear(info) || has_mask_norms(info, rules) || detail::DualBound::has(info);
    return support;
}

SchemeSupport scheme_support(const ControlMesh& mesh, const SchemeChoice& scheme, const RuleOptions& rules) {
    SchemeSupport support = scheme_support(scheme, rules);
    support.patches = support.patches && detail::has_plain_rules(mesh, scheme.info(), rules);
    if (!support.patches && has_mask_norms(scheme.info(), rules))
        support.certified = MaskNormBound<QuadFamily>::has(scheme.info(), rules, mesh);
    return support;
}

Tessellation detail::tessellate_by_limits(const ControlMesh& mesh, const TessellateOptions& options,
                                          const RunContext& context) {
    check_scheme(options);
    try {
        if (!scheme_support(options.scheme, options.rules).adaptive)
            return tessellate_by_levels(mesh, options, context);
        if (options.scheme.info().refinement == Refinement::sqrt3) return tessellate_sqrt3(mesh, options, context);
        const bool dual = fan_lattice(options.scheme.info(), options.rules) == FanLattice::dual;
        if (dual) return tessellate_dual(mesh, options, context);
        if (boundary_recedes(options.scheme.info(), options.rules) && mesh.has_boundary())
            return tessellate_by_levels(mesh, options, context,
                                        "a boundary that recedes leaves sites without vertex; replicate it");
        return tessellate_on_lattice(mesh, options, context);
    } catch (const Error& error) {
        // Here nothing goes without limits.
        constexpr std::string_view k_advice = "; leave out the limit";
        const std::string text = error.what();
        if (error.code() != ErrorCode::unsupported || !text.ends_with(k_advice)) throw;
        throw Error(ErrorCode::unsupported,
                    text.substr(0, text.size() - k_advice.size()) +
                        "; change the mesh there (its tags, or how many faces meet), or tessellate by another scheme");
    }
}

}  // namespace tetrakis
