// What is wrong with a scene file, collected, and the parts of the parser that collect it.
#pragma once

#include "engine/scene/scene_schema.h"
#include "engine/scene/toml_reader.h"

namespace pliant {

enum class Neighbourhood : std::uint8_t;

/// Collects faults, to be reported together.
class Findings {
public:
  Findings(std::filesystem::path file, const std::vector<std::string>& overrides)
      : file_(std::move(file)), overrides_(overrides) {}
  void add(const Where& where, std::string message) { found_.push_back({where, std::move(message)}); }
  std::size_t count() const { return found_.size(); }
  /// Throws Error(usage) with the first ten in order of place; returns where there are none.
  void raise();

private:
  struct Finding {
    Where where;
    std::string message;
  };
  std::filesystem::path file_;
  const std::vector<std::string>& overrides_;
  std::vector<Finding> found_;
};

/// "; did you mean 'young'?" where one of `known` is near (edits, or one begins the other), else "; known: a,
/// b, c".
std::string suggestion(std::string_view typed, const std::vector<std::string>& known);
/// The same for a key of a table; a key of another table is told its home.
std::string key_suggestion(std::string_view typed, const schema::Table& table);
/// A name as a message quotes it: shortened, without line breaks.
std::string in_quotes(std::string_view text);

/// Applies "key=value" to the tree before it is validated.
void apply_override(TomlValue& document, const std::string& text, int index, Findings& findings);

/// The rules that join several keys of one table; after its keys were read into `object`. `path` names the
/// table.
void check_table(const schema::Table& table, const TomlValue& value, void* object, const std::string& path,
                 Findings& findings);
/// Of these, those of laws over basis functions: of a material, and of its directions.
void check_basis_law(const TomlValue& value, Material& material, const std::string& path, Findings& findings);
/// Its constants and its energy, where the rest of it is sound.
void check_energy(const TomlValue& value, const Material& material, Neighbourhood neighbourhood,
                  const std::string& path, Findings& findings);
void check_directions(const TomlValue& value, Anisotropy& anisotropy, const std::string& path,
                      Findings& findings);
/// Of those that flow: a material's, and of the bodies that it fills.
void check_plastic(const TomlValue& value, Material& material, const std::string& path, Findings& findings);
void check_plastic_bodies(const TomlValue& document, const Scene& scene, Findings& findings);
/// Of fluids: a material's, and those of bodies, of the domain and of settings that go with them.
void check_fluid(const TomlValue& value, Material& material, const std::string& path, Findings& findings);
void check_fluids(const TomlValue& document, const Scene& scene, Findings& findings);
/// Of emitters and sinks, and what they need of the scene.
void check_emitter(const TomlValue& value, Emitter& emitter, const std::string& path, Findings& findings);
void check_sink(const TomlValue& value, Sink& sink, const std::string& path, Findings& findings);
void check_flow(const TomlValue& document, Scene& scene, Findings& findings);
/// The rules of horizons, of Poisson's ratios, of sheets and of plane scenes.
void check_flat(const TomlValue& document, Scene& scene, Findings& findings);
/// The rules that join tables.
void check_scene(const TomlValue& document, Scene& scene, Findings& findings);

} // namespace pliant
