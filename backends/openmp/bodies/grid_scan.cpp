// Scans the cells of a chunk; see kernels/grid_scan.decl.
#include "kernels/grid_scan.h"
#include "backends/openmp/body.h"
#include "backends/openmp/math.h"
#include "shaders/common/contact.glsl"

namespace pliant::openmp::PLIANT_ISA {

template <class real> void grid_scan(const kernels::grid_scan::View<real>& k) {
  const uint chunks = (k.cells + SCAN_CHUNK - 1) / SCAN_CHUNK;
#pragma omp parallel for schedule(static)
  for (uint chunk = 0; chunk < chunks; ++chunk) {
    uint begin = k.chunk_begin[chunk];
    for (uint cell = SCAN_CHUNK * chunk; cell < smaller(SCAN_CHUNK * (chunk + 1), k.cells); ++cell) {
      const uint count = k.cell_count[cell];
      k.cell_count[cell] = begin;
      k.cell_begin[cell] = begin;
      begin += count;
    }
    if (chunk + 1 == chunks) k.cell_begin[k.cells] = begin;
  }
}

PLIANT_BODY(grid_scan)

} // namespace pliant::openmp::PLIANT_ISA
