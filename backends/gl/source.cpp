// Writes the GLSL side of a kernel's declaration and expands its text.
#include "backends/gl/source.h"

#include "backends/gl/names_used.h"
#include "backends/gl/shader_text.h"
#include "engine/core/error.h"

#include <algorithm>
#include <cctype>
#include <cstring>
#include <sstream>

namespace pliant::gl {

namespace {

const char* type_name(Type type) {
  switch (type) {
  case Type::real:
    return "real";
  case Type::real4:
    return "real4";
  case Type::uint:
    return "uint";
  case Type::uint4:
    return "uint4";
  }
  return "";
}

[[noreturn]] void fail(const KernelInfo& kernel, const std::string& what) {
  throw Error(ExitCode::internal, std::string("kernel '") + kernel.name + "': " + what);
}

std::uint32_t option_value(const Field& field, const void* args) {
  std::uint32_t value = 0;
  std::memcpy(&value, static_cast<const char*>(args) + field.offset, sizeof value);
  return value;
}

std::string interface_text(const KernelInfo& kernel, const void* args, const std::set<std::string>& used) {
  std::ostringstream out;
  out << "#version 430 core\n#define real float\n#define real4 vec4\n#define uint4 uvec4\n#define GROUP "
      << kernel.group_size << "u\nlayout(local_size_x = " << kernel.group_size << ") in;\n";
  for (const Field& field : kernel.fields)
    if (field.role == Role::option)
      out << "#define " << field.name << " " << option_value(field, args) << "\n";
  out << "layout(std140, binding = " << parameter_slot << ") uniform " << kernel.name
      << "_parameters {\n  uint threads;\n";
  for (const Field& field : kernel.fields) {
    if (field.role != Role::parameter) continue;
    if (field.type != Type::real && field.type != Type::uint)
      fail(kernel, std::string("parameter '") + field.name + "' is not a scalar");
    out << "  " << type_name(field.type) << " " << field.name << ";\n";
  }
  out << "};\n";
  std::set<std::uint32_t> slots; // of this variant: fields that no variant uses together may share one
  for (const Field& field : kernel.fields) {
    if (field.role == Role::option || field.role == Role::parameter) continue;
    if (!used.count(field.name)) continue;
    if (field.role != Role::table && field.slot >= max_buffers)
      fail(kernel, "more than 8 storage buffers, which is all that OpenGL 4.3 promises");
    if (field.role != Role::table && !slots.insert(field.slot).second)
      fail(kernel, std::string("buffer '") + field.name + "' has the slot of another that this variant uses");
    if (field.role == Role::table) {
      // std140 would pad each scalar of an array to 16 bytes.
      if (field.type != Type::real4 && field.type != Type::uint4)
        fail(kernel, std::string("table '") + field.name + "' must hold real4 or uint4");
      if (field.slot >= parameter_slot)
        fail(kernel, std::string("table '") + field.name + "' has a slot too high");
      out << "layout(std140, binding = " << field.slot << ") uniform " << kernel.name << "_" << field.name
          << "_block { " << type_name(field.type) << " " << field.name << "[" << field.size << "]; };\n";
      continue;
    }
    // An output is not writeonly: a shader may read back what it wrote.
    out << "layout(std430, binding = " << field.slot << ") restrict "
        << (field.role == Role::in ? "readonly " : "") << "buffer " << kernel.name << "_" << field.name
        << "_block { " << type_name(field.type) << " " << field.name << "[]; };\n";
  }
  return out.str();
}

// The file named by a line such as `#include "common/tensor.glsl"`, or nothing.
std::string included_file(const std::string& line) {
  std::size_t at = line.find_first_not_of(" \t");
  if (at == std::string::npos || line[at] != '#') return {};
  at = line.find_first_not_of(" \t", at + 1);
  if (at == std::string::npos || line.compare(at, 7, "include") != 0) return {};
  const std::size_t open = line.find('"', at),
                    close = open == std::string::npos ? open : line.find('"', open + 1);
  return close == std::string::npos ? std::string() : line.substr(open + 1, close - open - 1);
}

} // namespace

void append_file(Source& source, const std::string& name, const Texts& texts) {
  const auto file = texts.find(name);
  if (file == texts.end()) throw Error(ExitCode::internal, "shader file '" + name + "' is not in this build");
  const std::size_t number = source.files.size();
  source.files.push_back(name);
  std::istringstream in(file->second);
  std::string line;
  for (std::size_t count = 1; std::getline(in, line); ++count) {
    const std::string included = included_file(line);
    if (included.empty()) {
      source.text += line + "\n";
      source.origins.push_back({number, count});
      continue;
    }
    if (std::find(source.files.begin(), source.files.end(), included) != source.files.end()) continue;
    if (!texts.count(included))
      throw Error(ExitCode::internal, name + ":" + std::to_string(count) + ": shader file '" + included +
                                          "' is not in this build");
    append_file(source, included, texts);
  }
}

Source expand_kernel(const KernelInfo& kernel, const void* args, const Texts& texts) {
  Source source;
  source.files.push_back(std::string("interface of ") + kernel.name);
  append_file(source, "common/threads.glsl", texts);
  append_file(source, std::string(kernel.name) + ".comp", texts);

  std::map<std::string, std::string> options;
  for (const Field& field : kernel.fields)
    if (field.role == Role::option) options[field.name] = std::to_string(option_value(field, args));
  const std::set<std::string> names = names_used(source.text, options);
  for (const Field& field : kernel.fields)
    if (field.role >= Role::table && names.count(field.name)) source.names.insert(field.name);
  const std::string interface = interface_text(kernel, args, source.names);
  std::vector<Source::Origin> origins;
  for (const char c : interface)
    if (c == '\n') origins.push_back({0, origins.size() + 1});
  source.text.insert(0, interface);
  source.origins.insert(source.origins.begin(), origins.begin(), origins.end());
  return source;
}

std::string readable_log(const std::string& log, const Source& source) {
  std::istringstream in(log);
  std::string result, line;
  const auto digits = [&](std::size_t from) {
    while (from < line.size() && std::isdigit(static_cast<unsigned char>(line[from]))) ++from;
    return from;
  };
  while (std::getline(in, line)) {
    // Mesa: "0:12(5): error: …"; NVIDIA: "0(12) : error …"; others: "ERROR: 0:12: …".
    std::size_t from = 0;
    for (const char* word : {"ERROR: ", "WARNING: "})
      if (line.rfind(word, 0) == 0) from = std::strlen(word);
    const bool numbered = line.compare(from, 2, "0:") == 0 || line.compare(from, 2, "0(") == 0;
    const std::size_t begin = from + 2, end = numbered ? digits(begin) : begin;
    const std::size_t place =
        end > begin && end - begin < 9 ? std::stoul(line.substr(begin, end - begin)) : 0;
    if (place > 0 && place <= source.origins.size()) {
      const auto [file, number] = source.origins[place - 1];
      const std::size_t rest = line[from + 1] == '(' && end < line.size() ? end + 1 : end;
      line.replace(from, rest - from, source.files[file] + ":" + std::to_string(number));
    }
    result += line + "\n";
  }
  return result;
}

std::string variant_name(const KernelInfo& kernel, const void* args) {
  std::string options;
  for (const Field& field : kernel.fields) {
    if (field.role != Role::option) continue;
    options.append(options.empty() ? "" : ",").append(field.name).append("=");
    options.append(std::to_string(option_value(field, args)));
  }
  return options.empty() ? kernel.name : std::string(kernel.name).append("[").append(options).append("]");
}

std::size_t parameter_bytes(const KernelInfo& kernel) {
  return 4 * (1 + std::count_if(kernel.fields.begin(), kernel.fields.end(),
                                [](const Field& field) { return field.role == Role::parameter; }));
}

std::string expanded_source(const KernelInfo& kernel, const void* args) {
  return expand_kernel(kernel, args, shader_texts()).text;
}

} // namespace pliant::gl
