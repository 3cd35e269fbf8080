// A triangle whose particles have lost each other; see kernels/surface_tear.decl.
#include "kernels/surface_tear.h"
#include "backends/openmp/body.h"
#include "backends/openmp/math.h"

namespace pliant::openmp::PLIANT_ISA {

template <class real> void surface_tear(const kernels::surface_tear::View<real>& k) {
#pragma omp parallel for schedule(static)
  for (uint local = 0; local < k.threads; ++local) {
    const uint t = k.first_triangle + local;
    const Uint4 corners = k.skin_triangle[t];
    uint particle[12], label[12];
    uint count = 0;
    for (const uint v : {corners.x, corners.y, corners.z})
      for (const uint i :
           {k.skin_particle[v].x, k.skin_particle[v].y, k.skin_particle[v].z, k.skin_particle[v].w}) {
        bool known = false;
        for (uint p = 0; p < count; ++p) known = known || particle[p] == i;
        if (!known) particle[count++] = i;
      }
    for (uint p = 0; p < count; ++p) label[p] = p;
    uint pieces = count;
    for (uint p = 0; p < count; ++p) {
      const uint i = particle[p] - k.first, slice = k.first_slice + i / 16, lane = i % 16;
      for (uint row = k.slice_begin[slice]; row < k.slice_begin[slice + 1]; ++row) {
        const uint j = k.bond[std::size_t{32} * row + lane];
        for (uint q = 0; q < count; ++q) {
          if (particle[q] != j || label[q] == label[p]) continue;
          const uint gone = label[q]; // two pieces become one
          for (uint r = 0; r < count; ++r)
            if (label[r] == gone) label[r] = label[p];
          --pieces;
        }
      }
    }
    k.torn[t] = pieces > corners.w ? 1 : 0;
  }
}

PLIANT_BODY(surface_tear)

} // namespace pliant::openmp::PLIANT_ISA
