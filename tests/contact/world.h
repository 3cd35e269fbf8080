// Particles, obstacles and the solver's buffers that contacts work on, without a solver.
#pragma once

#include "engine/solver/contact.h"
#include "shaders/common/contact.glsl"
#include "shaders/common/solver.glsl"
#include "tests/support/devices.h"

#include <gtest/gtest.h>

#include <random>

namespace pliant::test {

struct World {
  Scene scene;
  Model model;
  std::vector<Vector3> displacement; ///< m
  std::vector<double> stiffness;     ///< K_i, N/m
  std::vector<std::uint32_t> slice_begin{0}, bond{0};
  double step = 0.01;

  World() {
    scene.simulation.spacing = model.spacing = 0.1;
    scene.contact.bodies = false;
  }
  std::size_t count() const { return model.count(); }
  void add_body(const Vector3& origin) {
    BodyModel body;
    body.origin = origin;
    body.first = static_cast<std::uint32_t>(count());
    model.bodies.push_back(body);
  }
  /// To the body added last.
  void add(const Vector3& at, const Vector3& u = Vector3::Zero(), double k = 1000) {
    if (model.bodies.empty()) add_body(Vector3::Zero());
    model.position.push_back(at);
    model.mass.push_back(1);
    model.body.push_back(static_cast<std::uint32_t>(model.bodies.size() - 1));
    model.bodies.back().count += 1;
    displacement.push_back(u);
    stiffness.push_back(k);
  }
  void add_boundary(const Shape& shape, bool inside = false, double friction = 0) {
    Boundary boundary;
    boundary.shape = shape;
    boundary.inside = inside;
    boundary.friction = friction;
    scene.boundaries.push_back(boundary);
  }
};

/// A world on a device; after the constructor its contacts are found.
class Bench {
public:
  Bench(Device& device, const World& world)
      : device_(device), world_(world), contacts(device, world.scene, world.model, Vector3::Zero()) {
    const std::size_t n = world.count();
    std::vector<Real4<double>> position(n), displacement(n), start(n), origin;
    for (const BodyModel& body : world.model.bodies)
      origin.push_back({body.origin[0], body.origin[1], body.origin[2], 0});
    for (std::size_t i = 0; i < n; ++i) {
      const Vector3 y = world.model.position[i] - world.model.bodies[world.model.body[i]].origin;
      position[i] = {y[0], y[1], y[2], world.model.mass[i]};
      const Vector3& u = world.displacement[i];
      displacement[i] = {u[0], u[1], u[2], 0};
      start[i] = {0, 0, 0, world.stiffness[i]};
    }
    const auto real4 = [&](Buffer& buffer, const std::vector<Real4<double>>& values) {
      buffer = device.allocate("test", Type::real4, values.size());
      device.upload(buffer, values);
      return static_cast<BufferStorage*>(buffer);
    };
    const auto uints = [&](Buffer& buffer, const std::vector<std::uint32_t>& values) {
      buffer = device.allocate("test", Type::uint, values.size());
      device.upload(buffer, values);
      return static_cast<BufferStorage*>(buffer);
    };
    start_ = start;
    state.position = real4(position_, position);
    state.displacement = real4(displacement_, displacement);
    state.linear_start = real4(linear_, start);
    state.force = real4(force_, start);
    state.origin = real4(origin_, origin);
    state.owner = uints(owner_, world.model.body);
    state.slice_begin = uints(slices_, world.slice_begin);
    state.bond = uints(bonds_, world.bond);
    solver_ = device.allocate("solver", Type::real, SOLVER_ENTRIES);
    state.solver = solver_;
    contacts.begin_step(0, world.step, state);
    contacts.find(state);
  }

  void move(const std::vector<Vector3>& to) {
    std::vector<Real4<double>> values;
    for (const Vector3& u : to) values.push_back({u[0], u[1], u[2], 0});
    device_.upload(state.displacement, values);
  }
  /// From fresh elastic forces of zero; w: stiffness of the diagonal.
  std::vector<Real4<double>> forces() {
    device_.upload(state.force, start_);
    contacts.add_forces(state);
    return device_.download_real4(state.force);
  }
  std::vector<std::uint32_t> touched() { return device_.download_uint(contacts.touched()); }
  /// Sorted, without dropped ones.
  std::vector<std::vector<std::uint32_t>> lists() {
    const std::vector<std::uint32_t> raw = device_.download_uint(contacts.buffer("contact"));
    std::vector<std::vector<std::uint32_t>> result(world_.count());
    for (std::uint32_t i = 0; i < world_.count(); ++i)
      for (std::uint32_t a = 0; a < CONTACTS; ++a) {
        const std::uint32_t j = raw[256 * (i / 16) + 16 * a + i % 16];
        if (j == i) break;
        if (!(j & CONTACT_DROPPED)) result[i].push_back(j);
      }
    return result;
  }

private:
  Device& device_;
  const World& world_;
  Buffer position_, displacement_, linear_, force_, origin_, owner_, slices_, bonds_, solver_;
  std::vector<Real4<double>> start_;

public:
  ContactState state;
  Contacts contacts;
};

inline Vector3 vector_of(const Real4<double>& v) {
  return {v.x, v.y, v.z};
}

class ContactTest : public testing::TestWithParam<DeviceChoice> {
protected:
  std::unique_ptr<Device> device = GetParam().open();
  double epsilon = GetParam().epsilon();
};

} // namespace pliant::test
