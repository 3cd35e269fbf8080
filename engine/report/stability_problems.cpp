// The problems of the sweep: one body of the scene, in states and under settings that no scene file may ask
// for.
#include "engine/core/error.h"
#include "engine/model/initial_state.h"
#include "engine/report/stability.h"
#include "engine/scene/sample.h"

#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <random>

namespace pliant {

namespace {

using Points = std::vector<Vector3>;

/// A number in [-1, 1) for each component, the same on every machine.
Vector3 random_vector(std::mt19937& random) {
  const auto one = [&] { return static_cast<double>(random()) / 2147483648.0 - 1; };
  const double x = one(), y = one(), z = one();
  return {x, y, z};
}
/// Nearly normal, of variance one in each component: the sum of twelve uniform numbers (Irwin and Hall).
Vector3 gaussian(std::mt19937& random) {
  Vector3 sum = Vector3::Zero();
  for (int k = 0; k < 12; ++k) sum += random_vector(random) / 2;
  return sum;
}

Vector3 extent(const Points& points) {
  Vector3 low = Vector3::Constant(1e300), high = -low;
  for (const Vector3& x : points) low = low.cwiseMin(x), high = high.cwiseMax(x);
  return points.empty() ? Vector3::Zero() : Vector3(high - low);
}

Points lattice(int nx, int ny, int nz, double spacing) {
  Points points;
  for (int z = 0; z < nz; ++z)
    for (int y = 0; y < ny; ++y)
      for (int x = 0; x < nx; ++x) points.push_back(Vector3(x, y, z) * spacing);
  return points;
}

/// What all problems start from.
struct Base {
  Scene scene; ///< settings only
  Points points;
  double spacing = 0, size = 0; ///< m
  Vector3 sides = Vector3::Zero();
  int axis = 0; ///< along which it is longest

  StabilitySetup setup(const Points& at, double young, double poisson, double step) const {
    StabilitySetup made;
    made.scene = scene;
    Material& material = made.scene.materials.front();
    material.young = young;
    if (material.law != "projective") material.poisson = poisson;
    made.scene.simulation.time_step = step;
    made.scene.output.fps = 1 / step; // a frame is a step
    made.model = assemble_points(at, spacing, scene.simulation.horizon, material, std::pow(spacing, 3),
                                 scene.simulation.weights, scene.simulation.weight_exponent);
    made.position = made.model.position;
    made.velocity.assign(made.position.size(), Vector3::Zero());
    made.size = std::max(extent(made.position).norm(), spacing);
    return made;
  }
  bool inverts() const {
    const Material& material = scene.materials.front();
    return material.law == "corotated" || (material.law == "projective" && material.inversion != "swap");
  }
};

/// The largest sampling of the scene's first body within the number of particles.
Base base_of(const Scene& scene, std::size_t most) {
  if (scene.bodies.empty())
    throw Error(ExitCode::usage, "the scene has no body to judge: give it a [[body]]");
  const Body& body = scene.bodies.front();
  const Material* material = scene.material(body.material);
  if (!material)
    throw Error(ExitCode::usage,
                fmt::format("there is no material \"{}\" for body \"{}\"", body.material, body.name));
  Base base;
  base.spacing = scene.simulation.spacing;
  Sampling sampling = sample(body.shape, base.spacing, scene.file.parent_path());
  while (sampling.points.size() > most) {
    base.spacing *= std::max(1.02, std::cbrt(double(sampling.points.size()) / double(most)) * 0.999);
    sampling = sample(body.shape, base.spacing, scene.file.parent_path());
  }
  for (const Vector3& x : sampling.reference) base.points.push_back(sampling.origin + x);
  base.sides = extent(base.points) + Vector3::Constant(base.spacing);
  base.sides.maxCoeff(&base.axis);
  base.size = extent(base.points).norm();
  base.scene.name = scene.name;
  base.scene.simulation = scene.simulation;
  base.scene.simulation.spacing = base.spacing;
  base.scene.simulation.gravity.setZero();
  base.scene.solver = scene.solver;
  base.scene.solver.integrator = "implicit-euler"; // what the sweep's expectations of decay hold for
  base.scene.materials = {*material};
  base.scene.contact = {};
  base.scene.output.fields.clear();
  return base;
}

/// Whether a mode of angular frequency `omega` decays in so many steps from a strain of one to a tenth of
/// what counts as recovered: implicit Euler shrinks it by (1 + omega^2 h^2)^-1/2 a step.
bool decays(double omega, double step, unsigned steps) {
  return 0.5 * steps * std::log1p(omega * omega * step * step) > std::log(10 / stability_strain);
}

class Problems {
public:
  Problems(const Scene& scene, const StabilityOptions& options)
      : options_(options), base_(base_of(scene, options.particles)), young_(base_.scene.materials[0].young),
        poisson_(base_.scene.materials[0].poisson), density_(base_.scene.materials[0].density) {}

  std::vector<StabilityProblem> all() {
    map();
    ratios();
    for (const auto& [young, step] : {std::pair{young_, 1. / 30}, std::pair{1e9, 0.1}}) states(young, step);
    budgets();
    speeds();
    places();
    few();
    masses();
    rest();
    return std::move(problems_);
  }

private:
  using Change = std::function<void(StabilitySetup&)>;

  StabilityProblem& add(const std::string& name, double young, double poisson, double step,
                        std::function<StabilitySetup()> build) {
    problems_.push_back({.name = name,
                         .young = young,
                         .poisson = poisson,
                         .time_step = step,
                         .steps = options_.steps,
                         .iterations = options_.iterations,
                         .build = std::move(build)});
    return problems_.back();
  }

  /// The body itself, changed.
  StabilityProblem& body(const std::string& name, double young, double poisson, double step, Wanted wanted,
                         const Change& change) {
    const Base& base = base_;
    return add(name, young, poisson, step, [=] {
      StabilitySetup setup = base.setup(base.points, young, poisson, step);
      setup.wanted = wanted;
      change(setup);
      return setup;
    });
  }

  double wave(double young) const { return std::sqrt(young / density_); }
  /// The shape, where there is time for stretching (and bending) to die away.
  Wanted shape_in_time(double young, double step, bool bending) const {
    const double length = base_.sides.maxCoeff(), thickness = base_.sides.minCoeff();
    double omega = 3.14 * wave(young) / length;
    if (bending) omega = std::min(omega, 22.4 * wave(young) * thickness / std::sqrt(12) / (length * length));
    return decays(omega, step, options_.steps) ? Wanted::shape : Wanted::nothing;
  }

  static Vector3 centre(const StabilitySetup& setup) {
    return centre_of_mass(setup.position, setup.model.mass);
  }
  /// Moves particles relative to the centre of mass.
  static Change moved(const std::function<Vector3(const Vector3&, std::mt19937&)>& to) {
    return [to](StabilitySetup& setup) {
      const Vector3 c = centre(setup);
      std::mt19937 random(17);
      for (Vector3& y : setup.position) y = c + to(y - c, random);
    };
  }

  void map() {
    const std::vector<double> steps = {1e-4, 1e-3, 1e-2, 1. / 30, 0.1};
    for (double young = 1e3; young < 2e10; young *= 10)
      for (double step : steps) {
        StabilityProblem& made =
            body("map", young, poisson_, step, shape_in_time(young, step, false), moved(stretched(1.5, 0.2)));
        made.map = true;
        made.on_gl = (young == 1e3 || young == 1e6 || young == 1e10) && (step == 1e-4 || step > 0.03);
      }
  }

  std::function<Vector3(const Vector3&, std::mt19937&)> stretched(double by, double noise) const {
    const int axis = base_.axis;
    const double jitter = noise * base_.spacing;
    return [=](const Vector3& x, std::mt19937& random) {
      Vector3 y = x;
      y[axis] *= by;
      return Vector3(y + jitter * random_vector(random));
    };
  }

  void ratios() {
    if (base_.scene.materials[0].law == "projective") return; // has one ratio only
    for (double ratio : {0.0, 0.25, 0.4, 0.45, 0.49, 0.499})
      for (const auto& [young, step] : {std::pair{1e4, 1e-3}, std::pair{1e6, 1. / 30}, std::pair{1e9, 0.1}}) {
        StabilityProblem& made =
            body("ratio", young, ratio, step, shape_in_time(young, step, false), moved(stretched(1.5, 0.2)));
        made.on_gl = ratio == 0.499;
      }
  }

  void states(double young, double step) {
    const int axis = base_.axis;
    const double spacing = base_.spacing;
    const Vector3 half = base_.sides / 2;
    const Wanted shape = base_.inverts() ? shape_in_time(young, step, true) : Wanted::nothing;
    const auto add_state = [&](const std::string& name, Wanted wanted, bool gl, const auto& to) {
      body(name, young, poisson_, step, wanted, moved(to)).on_gl = gl;
    };
    const Matrix3 askew = Eigen::AngleAxisd(0.7, Vector3(1, 2, 3).normalized()).toRotationMatrix();
    const auto flat = [axis](const Vector3& x) {
      Vector3 y = x;
      y[axis] = 0;
      return y;
    };
    add_state("flattened", shape, true, [=](const Vector3& x, std::mt19937&) { return flat(x); });
    add_state("flattened askew", shape, false, [=](const Vector3& x, std::mt19937&) -> Vector3 {
      return askew.transpose() * flat(askew * x);
    });
    add_state("flattened with noise", shape, false, [=](const Vector3& x, std::mt19937& random) -> Vector3 {
      return flat(x) + 1e-6 * spacing * random_vector(random);
    });
    add_state("flattened across", shape, false, [=](const Vector3& x, std::mt19937&) {
      Vector3 y = x;
      y[(axis + 1) % 3] = 0;
      return y;
    });
    add_state("line", shape, true, [=](const Vector3& x, std::mt19937&) -> Vector3 { return x - flat(x); });
    add_state("point", shape, true, [](const Vector3&, std::mt19937&) -> Vector3 { return Vector3::Zero(); });
    add_state("mirrored", shape, true,
              [=](const Vector3& x, std::mt19937&) -> Vector3 { return 2 * flat(x) - x; });
    body("one particle pushed through", young, poisson_, step, shape, [spacing](StabilitySetup& setup) {
      const Vector3 c = centre(setup);
      Vector3& y = setup.position.front();
      y += (c - y).normalized() * 3 * spacing;
    });
    add_state("random in its box", shape, true, [half](const Vector3&, std::mt19937& random) -> Vector3 {
      return half.cwiseProduct(random_vector(random));
    });
    add_state("scattered by 0.5 spacings", shape, false,
              [=](const Vector3& x, std::mt19937& random) -> Vector3 {
                return x + 0.5 * spacing * gaussian(random);
              });
    add_state("scattered by 5 spacings", shape, false,
              [=](const Vector3& x, std::mt19937& random) -> Vector3 {
                return x + 5 * spacing * gaussian(random);
              });
    add_state("stretched fivefold", shape, true, stretched(5, 0));
    add_state("crushed to a twentieth", shape, true, stretched(0.05, 0));
    add_state("crushed on all sides", shape, false,
              [](const Vector3& x, std::mt19937&) -> Vector3 { return 0.05 * x; });
    add_state("inflated fivefold", shape, false,
              [](const Vector3& x, std::mt19937&) -> Vector3 { return 5 * x; });
    body("coincident pairs", young, poisson_, step, shape, [](StabilitySetup& setup) {
      for (std::size_t i = 1; i < setup.position.size(); i += 2) setup.position[i] = setup.position[i - 1];
    });
  }

  void budgets() {
    for (unsigned budget : {0u, 1u, 2u})
      for (const auto& [young, step] : {std::pair{1e5, 1. / 30}, std::pair{1e9, 0.1}}) {
        StabilityProblem& made = body(fmt::format("{} iterations", budget), young, poisson_, step,
                                      Wanted::nothing, moved(stretched(1.5, 0.2)));
        made.iterations = budget;
        made.on_gl = true;
      }
  }

  void speeds() {
    const double h = 1. / 30;
    body("flies at 1e4 m/s", young_, poisson_, h, Wanted::shape, [](StabilitySetup& setup) {
      setup.velocity.assign(setup.position.size(), Vector3(6e3, 8e3, 0));
    }).on_gl = true;
    body("hits a floor at 1e4 m/s", young_, poisson_, h, shape_in_time(young_, h, true),
         [](StabilitySetup& setup) {
           Boundary floor;
           floor.name = "floor";
           floor.shape.kind = Shape::Kind::plane;
           floor.shape.offset = centre(setup).y() - setup.size;
           setup.scene.boundaries = {floor};
           setup.velocity.assign(setup.position.size(), Vector3(0, -1e4, 0));
           setup.own_centre = true;
         })
        .on_gl = true;
    // Stiff enough that so much energy is not meant to throw it apart.
    body("spins at 1e3 rad/s", 1e9, poisson_, h, Wanted::nothing, [](StabilitySetup& setup) {
      const Vector3 c = centre(setup);
      for (std::size_t i = 0; i < setup.position.size(); ++i)
        setup.velocity[i] = Vector3(0, 0, 1e3).cross(setup.position[i] - c);
    }).on_gl = true;
    body("spins at 1e3 rad/s", 1e9, poisson_, 1e-4, Wanted::nothing, [](StabilitySetup& setup) {
      const Vector3 c = centre(setup);
      for (std::size_t i = 0; i < setup.position.size(); ++i)
        setup.velocity[i] = Vector3(0, 0, 1e3).cross(setup.position[i] - c);
    });
    body("one particle at 1e6 m/s", 1e10, poisson_, h, shape_in_time(1e10, h, true),
         [](StabilitySetup& setup) {
           setup.velocity.front() = {6e5, 8e5, 0};
         })
        .on_gl = true;
    for (const auto& [young, step] : {std::pair{1e10, h}, std::pair{1e10, 1e-4}})
      body("random speeds of 1e4 m/s", young, poisson_, step, shape_in_time(young, step, true),
           [](StabilitySetup& setup) {
             std::mt19937 random(23);
             for (Vector3& v : setup.velocity) v = 1e4 * random_vector(random);
           });
  }

  void places() {
    const auto scaled = [this](const std::string& name, double scale, const Vector3& shift) {
      Base base = base_;
      base.spacing *= scale;
      base.sides *= scale;
      base.scene.simulation.spacing = base.spacing;
      for (Vector3& x : base.points) x = scale * x + shift;
      const double young = young_, poisson = poisson_, step = scale / 30;
      const Wanted wanted = shape_in_time(young, 1. / 30, true);
      const auto to = stretched(1.5, 0);
      return &add(name, young, poisson, step, [=] {
        StabilitySetup setup = base.setup(base.points, young, poisson, step);
        setup.wanted = wanted;
        moved(to)(setup);
        return setup;
      });
    };
    scaled("1e6 spacings from the origin", 1, Vector3::Constant(1e6 * base_.spacing))->on_gl = true;
    scaled("a millionth of the size", 1e-6, Vector3::Zero())->on_gl = true;
    scaled("a million times the size", 1e6, Vector3::Zero())->on_gl = true;
  }

  void few() {
    const double s = base_.spacing, h = 1. / 30;
    const auto falling = [&](const std::string& name, const Points& points, bool gl) {
      const Base& base = base_;
      const double young = young_, poisson = poisson_;
      add(name, young, poisson, h, [=] {
        StabilitySetup setup = base.setup(points, young, poisson, h);
        setup.scene.simulation.gravity = {0, -9.81, 0};
        setup.wanted = Wanted::fall;
        return setup;
      }).on_gl = gl;
    };
    falling("no particle", {}, true);
    falling("1 particle", lattice(1, 1, 1, s), true);
    falling("2 particles", lattice(2, 1, 1, s), true);
    falling("3 particles", {{0, 0, 0}, {s, 0, 0}, {0, s, 0}}, true);
    falling("8 isolated particles", lattice(2, 2, 2, 10 * s), false);
    falling("a line of 5 particles", lattice(5, 1, 1, s), true);
    falling("a sheet of 5 by 5 particles", lattice(5, 5, 1, s), false);
    Points two = lattice(3, 3, 3, s);
    for (const Vector3& x : lattice(3, 3, 3, s)) two.push_back(x + Vector3(10 * s, 0, 0));
    falling("two pieces in one body", two, false);
    Points doubled = lattice(3, 3, 3, s);
    doubled.push_back(doubled.front());
    falling("a particle given twice", doubled, false);
  }

  void masses() {
    const double h = 1. / 60;
    for (double ratio : {1e1, 1e2, 1e3, 1e4}) {
      stack(fmt::format("{:g} times heavier on lighter", ratio), density_, ratio * density_, h, ratio == 1e4);
      stack(fmt::format("lighter on {:g} times heavier", ratio), ratio * density_, density_, h, false);
    }
    const Wanted wanted = Wanted::nothing; // slow modes of the heavy parts outlast the run
    const Change pull = moved(stretched(1.5, 0.2));
    const int axis = base_.axis;
    body("every other particle 1e4 times heavier", young_, poisson_, 1. / 30, wanted,
         [pull](StabilitySetup& setup) {
           for (std::size_t i = 0; i < setup.model.mass.size(); i += 2) setup.model.mass[i] *= 1e4;
           pull(setup);
         })
        .on_gl = true;
    body("one half 1e4 times heavier", young_, poisson_, 1. / 30, wanted,
         [pull, axis](StabilitySetup& setup) {
           const Vector3 c = centre(setup);
           pull(setup);
           for (std::size_t i = 0; i < setup.model.mass.size(); ++i)
             if (setup.model.position[i][axis] < c[axis]) setup.model.mass[i] *= 1e4;
         });
    body("one half 1e6 times stiffer", young_, poisson_, 1. / 30, wanted,
         [pull, axis](StabilitySetup& setup) {
           const Vector3 c = centre(setup);
           Material stiff = setup.scene.materials.front();
           stiff.young *= 1e6;
           setup.scene.materials.push_back(stiff);
           setup.model.constants.push_back(law_constants(stiff));
           setup.model.stretch.push_back(stretch_energy(stiff));
           for (std::size_t i = 0; i < setup.model.count(); ++i)
             if (setup.position[i][axis] < c[axis]) setup.model.material[i] = 1;
           pull(setup);
         })
        .on_gl = true;
  }

  /// Two cubes on a floor, so stiff that the lower one gives way by about a hundredth.
  void stack(const std::string& name, double lower, double upper, double h, bool gl) {
    constexpr int side = 5;
    const double s = base_.spacing, width = side * s;
    const double young = 100 * std::max(lower, upper) * 9.81 * 2 * width, poisson = poisson_;
    const Base& base = base_;
    add(name, young, poisson, h, [=] {
      StabilitySetup setup;
      Scene& scene = setup.scene;
      scene = base.scene;
      scene.simulation.gravity = {0, -9.81, 0};
      scene.simulation.time_step = h;
      scene.output.fps = 1 / h;
      Material material = scene.materials.front();
      material.young = young;
      scene.materials.clear();
      for (double density : {lower, upper}) {
        Body body;
        body.name = scene.bodies.empty() ? "lower" : "upper";
        body.material = material.name = body.name;
        material.density = density;
        scene.materials.push_back(material);
        body.shape.size = Vector3::Constant(width);
        body.shape.at = {0, width * (scene.bodies.empty() ? 0.5 : 1.5), 0};
        scene.bodies.push_back(body);
      }
      Boundary floor;
      floor.name = "floor";
      floor.shape.kind = Shape::Kind::plane;
      floor.friction = 0.5;
      scene.boundaries = {floor};
      setup.model = assemble(scene);
      setup.position = setup.model.position;
      setup.velocity = setup.model.velocity;
      setup.size = extent(setup.position).norm();
      setup.own_centre = true;
      setup.upper_first = setup.model.bodies[1].first;
      setup.wanted = Wanted::stack;
      return setup;
    }).on_gl = gl;
  }

  void rest() {
    body("rests in free space", young_, poisson_, 1. / 30, Wanted::still, [](StabilitySetup&) {}).on_gl =
        true;
    const auto resting = [](StabilitySetup& setup) {
      Boundary floor;
      floor.name = "floor";
      floor.shape.kind = Shape::Kind::plane;
      double low = 1e300;
      for (const Vector3& y : setup.position) low = std::min(low, y.y());
      floor.shape.offset = low - setup.scene.simulation.spacing / 2;
      floor.friction = 0.5;
      setup.scene.boundaries = {floor};
      setup.scene.simulation.gravity = {0, -9.81, 0};
      setup.own_centre = true;
    };
    StabilityProblem& floor = body("rests on a floor", young_, poisson_, 1. / 30, Wanted::still, resting);
    floor.on_gl = true;
    if (options_.full) floor.steps = 100'000;
  }

  const StabilityOptions& options_;
  Base base_;
  double young_, poisson_, density_;
  std::vector<StabilityProblem> problems_;
};

} // namespace

std::vector<StabilityProblem> stability_problems(const Scene& scene, const StabilityOptions& options) {
  return Problems(scene, options).all();
}

} // namespace pliant
