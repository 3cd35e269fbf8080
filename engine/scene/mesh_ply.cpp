// PLY: a header that describes its elements, then their values as text or as bytes of either order.
#include "engine/scene/mesh_file.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstring>
#include <fmt/format.h>
#include <limits>

namespace pliant::mesh_file {
namespace {

enum class Scalar : std::uint8_t { i8, u8, i16, u16, i32, u32, f32, f64 };

struct Property {
  std::string name;
  Scalar type = Scalar::f32;
  std::optional<Scalar> count; ///< of a list
};

struct Element {
  std::string name;
  std::size_t count = 0;
  std::vector<Property> properties;
};

std::optional<Scalar> scalar(std::string_view name) {
  constexpr std::array<std::array<std::string_view, 2>, 8> names{{{"char", "int8"},
                                                                  {"uchar", "uint8"},
                                                                  {"short", "int16"},
                                                                  {"ushort", "uint16"},
                                                                  {"int", "int32"},
                                                                  {"uint", "uint32"},
                                                                  {"float", "float32"},
                                                                  {"double", "float64"}}};
  for (std::size_t i = 0; i < names.size(); ++i)
    if (name == names[i][0] || name == names[i][1]) return static_cast<Scalar>(i);
  return std::nullopt;
}

std::size_t bytes_of(Scalar type) {
  constexpr std::array<std::size_t, 8> sizes{1, 1, 2, 2, 4, 4, 4, 8};
  return sizes[static_cast<std::size_t>(type)];
}

/// Values in the order of the file, whichever way it writes them.
class Values {
public:
  enum class Form { text, little, big };
  Values(const Input& input, Form form, std::size_t byte, std::size_t line)
      : input_(input), form_(form), at_(byte), line_(line) {}

  double next(Scalar type) { return form_ == Form::text ? next_word() : next_bytes(type); }

  /// Values that the rest of the file can hold at most: so that a false count cannot claim all memory.
  std::size_t room(std::size_t bytes_each) const {
    const std::size_t left = input_.bytes.size() - at_;
    return form_ == Form::text ? left / 2 + 1 : left / std::max<std::size_t>(bytes_each, 1);
  }

  [[noreturn]] void fail(const std::string& what) const {
    if (form_ == Form::text) fail_at_line(input_, line_, what);
    fail_at_byte(input_, at_, what);
  }
  void doing(std::string what) { doing_ = std::move(what); }

private:
  double next_word() {
    const std::string& text = input_.bytes;
    const auto blank = [&] { return text[at_] == ' ' || (text[at_] >= '\t' && text[at_] <= '\r'); };
    for (; at_ < text.size() && blank(); ++at_) line_ += text[at_] == '\n';
    const std::size_t begin = at_;
    while (at_ < text.size() && !blank()) ++at_;
    if (at_ == begin) fail("the file ends in " + doing_);
    const std::string_view word(text.data() + begin, at_ - begin);
    const std::optional<double> value = to_real(word);
    if (!value) fail(fmt::format("a number expected, not '{}'", word));
    return *value;
  }

  double next_bytes(Scalar type) {
    const std::size_t size = bytes_of(type);
    if (at_ + size > input_.bytes.size()) fail("the file ends in " + doing_);
    std::array<char, 8> raw{};
    std::copy_n(input_.bytes.data() + at_, size, raw.begin());
    if ((form_ == Form::big) != (std::endian::native == std::endian::big))
      std::reverse(raw.begin(), raw.begin() + static_cast<std::ptrdiff_t>(size));
    at_ += size;
    const auto as = [&]<class T>(T value) {
      std::memcpy(&value, raw.data(), sizeof(T));
      return static_cast<double>(value);
    };
    switch (type) {
    case Scalar::i8:
      return as(std::int8_t{});
    case Scalar::u8:
      return as(std::uint8_t{});
    case Scalar::i16:
      return as(std::int16_t{});
    case Scalar::u16:
      return as(std::uint16_t{});
    case Scalar::i32:
      return as(std::int32_t{});
    case Scalar::u32:
      return as(std::uint32_t{});
    case Scalar::f32:
      return as(float{});
    case Scalar::f64:
      break;
    }
    return as(double{});
  }

  const Input& input_;
  Form form_;
  std::size_t at_, line_;
  std::string doing_;
};

struct Header {
  Values::Form form = Values::Form::text;
  std::vector<Element> elements;
};

Header read_header(Lines& lines) {
  Header header;
  bool form_given = false;
  if (!lines.next() || lines.words()[0] != "ply") lines.fail("a PLY file begins with the word 'ply'");
  for (;;) {
    if (!lines.next()) lines.fail("the file ends before 'end_header'");
    const auto& words = lines.words();
    const auto type_or_fail = [&](std::size_t w) {
      const std::optional<Scalar> type = w < words.size() ? scalar(words[w]) : std::nullopt;
      if (!type) lines.fail(fmt::format("'{}' is no type of PLY", w < words.size() ? words[w] : ""));
      return *type;
    };
    if (words[0] == "end_header") break;
    if (words[0] == "comment" || words[0] == "obj_info") continue;
    if (words[0] == "format" && words.size() > 1) {
      if (words[1] == "ascii")
        header.form = Values::Form::text;
      else if (words[1] == "binary_little_endian")
        header.form = Values::Form::little;
      else if (words[1] == "binary_big_endian")
        header.form = Values::Form::big;
      else
        lines.fail(fmt::format("'{}' is no format of PLY", words[1]));
      form_given = true;
    } else if (words[0] == "element" && words.size() == 3) {
      const long long count = lines.integer(2);
      if (count < 0) lines.fail(fmt::format("{} elements: an impossible number", count));
      header.elements.push_back({std::string(words[1]), static_cast<std::size_t>(count), {}});
    } else if (words[0] == "property" && words.size() >= 3) {
      if (header.elements.empty()) lines.fail("a property before the first element");
      Property property;
      const bool list = words[1] == "list";
      if (words.size() != (list ? 5u : 3u)) lines.fail("a property is 'TYPE NAME' or 'list TYPE TYPE NAME'");
      if (list) property.count = type_or_fail(2);
      property.type = type_or_fail(list ? 3 : 1);
      property.name = words.back();
      header.elements.back().properties.push_back(property);
    } else {
      lines.fail(
          fmt::format("'{}' does not belong here in the header of a PLY file", words[0].substr(0, 40)));
    }
  }
  if (!form_given) lines.fail("the header names no format");
  return header;
}

} // namespace

Mesh read_ply(const Input& input) {
  Lines lines(input, '\0');
  const Header header = read_header(lines);
  Values values(input, header.form, lines.end(), lines.number() + 1);
  Mesh mesh;
  std::size_t vertices = 0;
  for (const Element& element : header.elements)
    if (element.name == "vertex") vertices = element.count;
  if (vertices > std::numeric_limits<std::uint32_t>::max())
    lines.fail("more vertices than 32 bits can number");
  std::vector<std::uint32_t> corners;
  for (const Element& element : header.elements) {
    const bool vertex = element.name == "vertex", face = element.name == "face";
    std::array<bool, 3> found{};
    std::size_t least = 0;
    bool listed = false;
    for (const Property& p : element.properties) {
      least += bytes_of(p.count.value_or(p.type));
      for (std::size_t k = 0; k < 3; ++k)
        found[k] = found[k] || (!p.count && p.name == std::string(1, "xyz"[k]));
      listed = listed || (p.count && (p.name == "vertex_indices" || p.name == "vertex_index"));
    }
    if (vertex && !(found[0] && found[1] && found[2])) lines.fail("the vertices lack x, y or z");
    if (face && element.count > 0 && !listed) lines.fail("the faces lack the list vertex_indices");
    values.doing(fmt::format("the {} elements '{}'", element.count, element.name));
    if (!element.properties.empty() && element.count > values.room(least))
      values.fail(fmt::format("{} elements '{}' announced, more than the rest of the file can hold",
                              element.count, element.name));
    if (element.properties.empty()) continue;
    for (std::size_t i = 0; i < element.count; ++i) {
      Vector3 position = Vector3::Zero();
      for (const Property& p : element.properties) {
        if (!p.count) {
          const double value = values.next(p.type);
          for (int k = 0; vertex && k < 3; ++k) {
            if (p.name.size() != 1 || p.name[0] != "xyz"[k]) continue;
            if (!std::isfinite(value))
              values.fail(fmt::format("{} of vertex {} is not a finite number", p.name, i));
            position[k] = value;
          }
          continue;
        }
        const double length = values.next(*p.count);
        const bool polygon = face && (p.name == "vertex_indices" || p.name == "vertex_index");
        if (!(length >= 0) || length != std::floor(length))
          values.fail(fmt::format("a list of {} values", length));
        if (polygon && length < 3) values.fail(fmt::format("face {} has {} corners; it needs 3", i, length));
        corners.clear();
        for (double c = 0; c < length; ++c) {
          const double index = values.next(p.type);
          if (!polygon) continue;
          if (!(index >= 0 && index < static_cast<double>(vertices)) || index != std::floor(index))
            values.fail(fmt::format("vertex {} of face {} does not exist: there are {} vertices", index, i,
                                    vertices));
          corners.push_back(static_cast<std::uint32_t>(index));
        }
        if (polygon) add_fan(mesh, corners);
      }
      if (vertex) mesh.vertices.push_back(position);
    }
  }
  return mesh;
}

} // namespace pliant::mesh_file
