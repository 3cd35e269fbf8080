// The rules of materials whose law is one over basis functions.
#include "engine/core/error.h"
#include "engine/model/anisotropy.h"
#include "engine/scene/scene_parse_findings.h"

#include <fmt/format.h>

namespace pliant {
namespace {

/// Adds what `work` throws.
template <class Work>
void find_fault(const Where& where, const std::string& path, Findings& findings, const Work& work) {
  try {
    work();
  } catch (const Error& error) {
    findings.add(where, fmt::format("{}: {}", path, error.what()));
  }
}

} // namespace

void check_directions(const TomlValue& value, Anisotropy& anisotropy, const std::string& path,
                      Findings& findings) {
  anisotropy.given = true;
  anisotropy.around = value.find("around") != nullptr;
  const TomlValue* first = nullptr;
  for (const char* key : {"directions", "rotate", "around"}) {
    const TomlValue* typed = value.find(key);
    if (typed && first)
      findings.add(typed->key_where,
                   fmt::format("{}.{}: {} has said already which directions they are; leave one out", path,
                               key, first->key));
    if (typed && !first) first = typed;
  }
  const TomlValue* typed = value.find("directions");
  find_fault(typed ? typed->where : value.where, path, findings, [&] { check_anisotropy(anisotropy); });
}

void check_basis_law(const TomlValue& value, Material& material, const std::string& path,
                     Findings& findings) {
  const std::string& law = material.law;
  const auto refuse = [&](const char* key, const std::string& laws) {
    if (const TomlValue* entry = value.find(key))
      findings.add(entry->key_where,
                   fmt::format("{}.{} applies to law = {} only; this law is \"{}\"", path, key, laws, law));
  };
  const bool has_form = law == "stvk" || law == "neo-hookean";
  if (!has_form) refuse("form", "\"stvk\" or \"neo-hookean\"");
  if (law != "basis") refuse("basis", "\"basis\"");
  if (law != "basis" && law != "stvk") refuse("calibration", "\"basis\" or \"stvk\"");
  if (law != "basis" && !has_form) {
    refuse("anisotropy", "\"basis\", \"stvk\" or \"neo-hookean\"");
    return;
  }
  if (has_form && material.form.empty()) material.form = "exact";
  if (law == "neo-hookean" && material.form == "exact") { // a stress of the deformation gradient: no bonds
    if (const TomlValue* entry = value.find("anisotropy"))
      findings.add(
          entry->key_where,
          fmt::format("{}.anisotropy: law \"neo-hookean\" has directions with form = \"bonds\" only; "
                      "its form is \"exact\" unless given",
                      path));
    return;
  }
  const TomlValue* basis = value.find("basis");
  if (law == "basis" && !basis)
    findings.add(value.where,
                 fmt::format("{} lacks 'basis' (the energies of law \"basis\"), such as basis = {{ g = {{ "
                             "A2 = 1.0 }}, h = {{ A4 = 0.5, B1 = 0.5 }} }}",
                             path));
  if (law == "basis" && basis)
    for (const auto& [key, shares] : {std::pair{"g", &material.volume_basis}, {"h", &material.bond_basis}})
      if (const TomlValue* typed = basis->find(key); typed && typed->kind == TomlValue::Kind::table)
        find_fault(typed->where, fmt::format("{}.basis.{}", path, key), findings,
                   [&, listed = shares] { basis_sum(*listed); });
}

void check_energy(const TomlValue& value, const Material& material, Neighbourhood neighbourhood,
                  const std::string& path, Findings& findings) {
  const TomlValue* blamed = value.find(material.law == "basis" ? "basis" : "law");
  find_fault(blamed ? blamed->where : value.where, path, findings, [&] {
    law_constants(material, neighbourhood);
    stretch_energy(material, neighbourhood);
  });
}

} // namespace pliant
