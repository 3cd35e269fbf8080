// The rules of emitters and sinks.
#include "engine/scene/scene_parse_findings.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace pliant {
namespace {

using Kind = TomlValue::Kind;

std::string place_of(const TomlValue& table, const char* key) {
  const TomlValue* typed = table.find(key);
  const Where& where = typed ? typed->where : table.where;
  return where.override_index >= 0 ? "" : fmt::format(":{}:{}", where.line, where.column);
}

} // namespace

void check_emitter(const TomlValue& value, Emitter& emitter, const std::string& path, Findings& findings) {
  emitter.typed_at = place_of(value, "nozzle");
  if (const TomlValue* nozzle = value.find("nozzle"); nozzle && nozzle->kind == Kind::table) {
    const bool disc = nozzle->find("disc"), rectangle = nozzle->find("rectangle");
    if (disc == rectangle)
      findings.add(nozzle->where, fmt::format("{}.nozzle must have exactly one of disc, rectangle; it has {}",
                                              path, disc ? "both" : "none"));
    if (const TomlValue* along = value.find("along"); along && disc)
      findings.add(along->key_where,
                   fmt::format("{}.along lays a rectangle's first edge; a disc has none", path));
  }
  if (const TomlValue* along = value.find("along");
      along && emitter.along && !(emitter.along->cross(emitter.direction).norm() > 1e-6))
    findings.add(along->where, fmt::format("{}.along is parallel to the direction; it lies across it", path));
  if (const TomlValue* stop = value.find("stop"); stop && emitter.stop <= emitter.start)
    findings.add(stop->where, fmt::format("{}.stop = {} must be after {}.start = {}", path, emitter.stop,
                                          path, emitter.start));
}

void check_sink(const TomlValue& value, Sink& sink, const std::string& path, Findings& findings) {
  sink.typed_at = place_of(value, "region");
  const TomlValue* region = value.find("region");
  if (region && (sink.region.kind == Shape::Kind::mesh || sink.region.kind == Shape::Kind::sheet))
    findings.add(region->where, fmt::format("{}.region is a box, sphere, cylinder, torus or plane; a {} is "
                                            "none of them",
                                            path, sink.region.kind == Shape::Kind::mesh ? "mesh" : "sheet"));
}

void check_flow(const TomlValue& document, Scene& scene, Findings& findings) {
  if (const TomlValue* typed = document.find("simulation"); typed && typed->kind == Kind::table)
    if (const TomlValue* capacity = typed->find("capacity")) {
      scene.simulation.capacity_at = place_of(*typed, "capacity");
      if (!scene.flows())
        findings.add(capacity->key_where, "simulation.capacity is of fluids, which emitters add to; the "
                                          "scene has none");
    }
  const TomlValue* emitters = document.find("emitter");
  const bool plane = scene.simulation.dimension == 2;
  for (std::size_t e = 0; e < scene.emitters.size(); ++e) {
    const TomlValue& table = emitters->items[e];
    const Emitter& emitter = scene.emitters[e];
    const std::string path = fmt::format("emitter.{}", e);
    if (table.kind != Kind::table) continue;
    const TomlValue* material = table.find("material");
    if (const Material* m = scene.material(emitter.material); material && m && !m->fluid())
      findings.add(material->where, fmt::format("{}.material = \"{}\" is elastic: only fluids come out of a "
                                                "nozzle; its model would have to be \"fluid\"",
                                                path, emitter.material));
    for (const Body& body : scene.bodies)
      if (const TomlValue* name = table.find("name"); body.name == emitter.name)
        findings.add(name ? name->where : table.where,
                     fmt::format("{}: a body is named \"{}\" too; names must differ", path, body.name));
    if (plane && (emitter.at.z() != 0 || std::abs(emitter.direction.z()) > 0))
      findings.add(table.find(emitter.at.z() != 0 ? "at" : "direction")->where,
                   fmt::format("{} with dimension = 2: everything stays in the plane z = 0", path));
    if (!emitter.particles && emitter.stop >= 1e300 && !scene.simulation.capacity)
      findings.add(table.where, fmt::format("{} never ends: say how many particles there may be at once, "
                                            "[simulation] capacity, or give it a stop or particles",
                                            path));
  }
  if (const TomlValue* sinks = document.find("sink"); sinks && !scene.sinks.empty() && !scene.flows())
    findings.add(sinks->where, "sink: only fluids run into one; the scene has none");
}

} // namespace pliant
