// Triangles small enough to tear between particles.
#include "engine/scene/mesh_refine.h"

#include <map>

namespace pliant {

Mesh refine(Mesh mesh, double longest) {
  for (bool again = true; again;) {
    again = false;
    std::map<std::pair<std::uint32_t, std::uint32_t>, std::uint32_t> middles;
    const auto middle = [&](std::uint32_t a, std::uint32_t b) -> std::optional<std::uint32_t> {
      if ((mesh.vertices[a] - mesh.vertices[b]).norm() <= longest) return std::nullopt;
      const auto next = static_cast<std::uint32_t>(mesh.vertices.size());
      const auto [found, is_new] = middles.try_emplace(std::minmax(a, b), next);
      if (is_new) {
        const Vector3 half = (mesh.vertices[a] + mesh.vertices[b]) / 2;
        mesh.vertices.push_back(half);
      }
      return found->second;
    };
    std::vector<std::array<std::uint32_t, 3>> finer;
    for (std::array<std::uint32_t, 3> t : mesh.triangles) {
      std::array<std::optional<std::uint32_t>, 3> half{middle(t[0], t[1]), middle(t[1], t[2]),
                                                       middle(t[2], t[0])};
      const int halved = int(half[0].has_value()) + int(half[1].has_value()) + int(half[2].has_value());
      again = again || halved > 0;
      // Turned so that the first edge is halved and, of two, the second is too.
      for (int turn = 0; turn < 2 && halved > 0 && halved < 3; ++turn)
        if (!half[0] || (halved == 2 && !half[1])) {
          t = {t[1], t[2], t[0]};
          half = {half[1], half[2], half[0]};
        }
      if (halved == 0) {
        finer.push_back(t);
      } else if (halved == 1) {
        finer.push_back({t[0], *half[0], t[2]});
        finer.push_back({*half[0], t[1], t[2]});
      } else {
        finer.push_back({*half[0], t[1], *half[1]});
        if (halved == 2) {
          finer.push_back({t[0], *half[0], *half[1]});
          finer.push_back({t[0], *half[1], t[2]});
        } else {
          finer.push_back({t[0], *half[0], *half[2]});
          finer.push_back({*half[2], *half[1], t[2]});
          finer.push_back({*half[0], *half[1], *half[2]});
        }
      }
    }
    mesh.triangles = std::move(finer);
  }
  return mesh;
}

} // namespace pliant
