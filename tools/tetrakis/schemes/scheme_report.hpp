#pragma once

#include "../report.hpp"

#include "../../../eval/estimate/mask_norm_bound.hpp"
#include "../../../schemes/analysis/spectrum.hpp"

#include <optional>
#include <string>
#include <vector>

namespace tetrakis::cli {

/// Results that the command "scheme" reports.
struct SchemeFindings {
    const SchemeInfo& scheme;
    RuleOptions rules;
    SpectralAnalysis analysis;
    SchemeMasks masks;
    int valence, reproduction;
    double support;
    std::optional<tetrakis::detail::CellNormTable::Total> mask_norm;

    bool boundary() const { return analysis.matrix.labels.shape().boundary; }
};

/// The scheme's title, with its number of averaging steps.
std::string title_of(const SchemeFindings& f);
std::string looked_at(const SchemeFindings& f, const FanLabels& labels);
std::string place_name(const FanLabels& labels, FanLabel label);
/// Rows of the matrix for the new points near the middle, one of each kind.
std::vector<int> shown_rows(const LocalMatrix& m);
std::vector<double> row_of(const LocalMatrix& m, int i);

void print_scheme(const SchemeFindings& f, bool with_matrix);
Json scheme_json(const SchemeFindings& f, bool with_matrix);

}  // namespace tetrakis::cli
