// A scene as JSON: the schema's tables, walked.
#include "engine/scene/scene_json.h"

#include "engine/scene/scene_schema.h"

#include <nlohmann/json.hpp>

namespace pliant {
namespace {

using nlohmann::json;

json number_json(double stored, double scale) {
  if (stored >= schema::never) return nullptr;
  return stored / scale;
}

json table_json(const schema::Table& table, void* object) {
  json result = json::object();
  for (const schema::Key& key : table.keys) {
    if (key.applies && !key.applies(object)) continue;
    json& value = result[std::string(key.name)];
    if (!key.nested.table) {
      value = schema::value_json(key, object);
      continue;
    }
    const std::vector<void*> children = key.nested.all(object);
    switch (key.nested.how) {
    case schema::Nested::How::one:
      if (!children.empty()) value = table_json(*key.nested.table, children.front());
      break;
    case schema::Nested::How::list:
      value = json::array();
      for (void* child : children) value.push_back(table_json(*key.nested.table, child));
      break;
    case schema::Nested::How::named:
      value = json::object();
      for (void* child : children)
        value[static_cast<Material*>(child)->name] = table_json(*key.nested.table, child);
      break;
    }
  }
  return result;
}

} // namespace

json schema::value_json(const Key& key, void* object) {
  struct Visitor {
    const Key& key;
    json operator()(const bool* v) const {
      if (key.choices.empty()) return *v;
      return key.choices[*v ? 1 : 0];
    }
    json operator()(const std::optional<bool>* v) const { return *v ? json(**v) : json(); }
    json operator()(const int* v) const { return *v; }
    json operator()(const unsigned* v) const { return *v; }
    json operator()(const std::optional<unsigned>* v) const { return *v ? json(**v) : json(); }
    json operator()(const double* v) const { return number_json(*v, key.scale); }
    json operator()(const std::optional<double>* v) const {
      return *v ? number_json(**v, key.scale) : json();
    }
    json operator()(const std::string* v) const { return *v; }
    json operator()(const Vector3* v) const { return {v->x(), v->y(), v->z()}; }
    json operator()(const std::optional<Vector3>* v) const { return *v ? (*this)(&**v) : json(); }
    json operator()(const Matrix3* v) const {
      json rows = json::array();
      for (int i = 0; i < 3; ++i) rows.push_back({(*v)(i, 0), (*v)(i, 1), (*v)(i, 2)});
      return rows;
    }
    json operator()(const std::array<unsigned, 2>* v) const { return *v; }
    json operator()(const std::array<bool, 3>* v) const { return *v; }
    json operator()(const std::optional<std::array<double, 2>>* v) const { return *v ? json(**v) : json(); }
    json operator()(const std::vector<std::string>* v) const { return *v; }
    json operator()(const std::map<std::string, double>* v) const { return *v; }
    json operator()(const Flags& v) const {
      json words = json::array();
      for (std::size_t i = 0; i < v.raised.size(); ++i)
        if (*v.raised[i]) words.push_back(key.choices[i]);
      return words;
    }
  };
  return std::visit([&](auto place) { return Visitor{key}(place); }, key.slot(object));
}

json scene_to_json(const Scene& scene) {
  // Slots are made for reading files, so they are not const; nothing is written here.
  return table_json(schema::root(), const_cast<Scene*>(&scene));
}

} // namespace pliant
