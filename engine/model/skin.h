// Ties the vertices of a carried mesh to the particles nearest to them at rest.
#pragma once

#include "engine/model/model.h"
#include "kernels/kernel.h"

namespace pliant {

/// Vertices of all bodies' meshes, body after body.
struct Skin {
  std::vector<Uint4> particle;          ///< four nearest, nearest first
  std::vector<Real4<double>> weight;    ///< sum 1; falls to zero at the distance of the fifth: no seams
  std::vector<Real4<double>> reference; ///< body axes, m
  std::vector<std::uint32_t> first;     ///< first vertex of each body, and the total
};

Skin make_skin(const Model& model);

/// Triangles of all bodies' meshes, body after body: three vertices of the skin, and in how many pieces the
/// particles that they follow hang together at rest, by distances that bonds of the body reach. Cuts do not
/// count: what is cut tears from the start.
struct SkinTriangles {
  std::vector<Uint4> triangle;
  std::vector<std::uint32_t> first; ///< first triangle of each body, and the total
};

SkinTriangles make_skin_triangles(const Model& model, const Skin& skin);

} // namespace pliant
