// Small scenes that switch one component on each.
#pragma once

#include "engine/model/model.h"
#include "engine/plan/plan.h"

#include <functional>

namespace pliant::test {

struct PlanScene {
  Scene scene;
  Model model;
  PlanRequest request;
};

inline std::vector<Vector3> lattice_box(int nx, int ny, int nz, double spacing) {
  std::vector<Vector3> points;
  for (int z = 0; z < nz; ++z)
    for (int y = 0; y < ny; ++y)
      for (int x = 0; x < nx; ++x) points.push_back(spacing * Vector3(x, y, z));
  return points;
}

/// A body and nothing else: no momentum restored, no rows, no frames.
inline PlanScene elastic_only(const std::string& law = "corotated",
                              const std::vector<Vector3>& points = lattice_box(4, 4, 5, 0.02)) {
  PlanScene made;
  Material material;
  material.name = "rubber";
  material.law = law;
  material.poisson = law == "projective" ? 0.25 : 0.3;
  if (law == "basis") material.volume_basis = material.bond_basis = {{"A2", 1.0}};
  made.scene.simulation.spacing = 0.02;
  made.scene.simulation.gravity = {0, -9.81, 0};
  made.scene.solver.method = "chebyshev";
  made.scene.solver.iterations = 4;
  made.scene.solver.restore_momentum = false;
  made.scene.materials = {material};
  made.model = assemble_points(points, 0.02, 1.87, material, 8e-6);
  made.model.velocity[0] = {0.5, 0, 0}; // in free fall alone there would be nothing to solve
  made.request.statistics = false;
  return made;
}

struct Switch {
  const char* component; ///< as the plan names it
  std::function<void(PlanScene&)> on;
};

inline Boundary floor_below() {
  Boundary boundary;
  boundary.shape.kind = Shape::Kind::plane;
  boundary.shape.normal = {0, 1, 0};
  boundary.shape.offset = -0.02;
  return boundary;
}

/// A box of triangles around the body, which carries it.
inline Mesh carried_box() {
  Mesh mesh;
  for (int corner = 0; corner < 8; ++corner)
    mesh.vertices.push_back(0.02 * Vector3(corner & 1 ? 3 : 0, corner & 2 ? 3 : 0, corner & 4 ? 4 : 0));
  return mesh;
}

inline std::vector<Switch> switches() {
  return {
      {"bdf2", [](PlanScene& s) { s.scene.solver.integrator = "bdf2"; }},
      {"held particles",
       [](PlanScene& s) {
         s.model.motions = {Motion{}};
         s.model.held = {{0, 0}, {3, 0}};
       }},
      {"loads",
       [](PlanScene& s) {
         s.model.loads = {{5, Vector3(1, 0, 0)}};
       }},
      {"boundaries", [](PlanScene& s) { s.scene.boundaries = {floor_below()}; }},
      {"contacts", [](PlanScene& s) { s.scene.contact.self = true; }},
      {"momentum", [](PlanScene& s) { s.scene.solver.restore_momentum = true; }},
      {"failure",
       [](PlanScene& s) { // the projective law's bonds do not break
         Material& material = s.scene.materials[0];
         if (material.law != "projective") material.critical_stretch = 10;
       }},
      {"statistics", [](PlanScene& s) { s.request.statistics = true; }},
      {"divergence", [](PlanScene& s) { s.request.divergence = true; }},
      {"frames", [](PlanScene& s) { s.request.frames = true; }},
      {"strain",
       [](PlanScene& s) {
         s.request.frames = true;
         s.request.fields = {"strain"};
       }},
      {"energy",
       [](PlanScene& s) {
         s.request.frames = true;
         s.scene.render.color = "energy";
       }},
      {"surfaces",
       [](PlanScene& s) {
         s.request.frames = true;
         BodyModel& body = s.model.bodies[0];
         body.surface = carried_box();
         for (const Vector3& v : body.surface->vertices) body.surface_reference.push_back(v - body.origin);
       }},
  };
}

} // namespace pliant::test
