#pragma once

#include "../../schemes/core/stencil_table.hpp"

#include <filesystem>

namespace tetrakis {

class AtomicFile;  // hier/base/files.hpp

/// Writes a stencil table as text, for programs that refine with their own kernels:
///
///     tetrakis-stencils 2
///     <rows> <control vertices> <terms>
///     <where each row begins, and the number of terms: rows + 1 numbers>
///     <control vertex of each term>
///     <weight of each term>
///
/// These are compressed rows (CSR), one line for each array. Row r has the terms from begin r to before begin r + 1.
/// Vertices and terms count from 0; vertices increase along a row; weights are the shortest decimals that read back the
/// same. Row r, applied to control values term by term from the left, gives the value of refined vertex r.
/// @throws Error  io
void write_stencils(const std::filesystem::path& path, const StencilTable& table, int control_vertices);
/// The same into a file that the caller commits.
void write_stencils(AtomicFile& file, const StencilTable& table, int control_vertices);

}  // namespace tetrakis
