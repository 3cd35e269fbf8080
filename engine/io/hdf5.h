// Small owning types over the C API of HDF5 1.10: files, groups, datasets that grow, virtual datasets,
// attributes. Nothing of HDF5 prints; each failure is thrown as Error(input_output) naming file, object and
// HDF5's own reason. Not for use by several threads at a time: the library that Debian ships is not
// thread-safe.
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <span>
#include <string>
#include <type_traits>
#include <vector>

namespace pliant::h5 {

using Id = std::int64_t; ///< what HDF5 calls hid_t

enum class Type { float32, float64, int32, uint32, int64, uint64, uint8 };
template <class T> constexpr Type type_of() {
  if constexpr (std::is_same_v<T, float>)
    return Type::float32;
  else if constexpr (std::is_same_v<T, double>)
    return Type::float64;
  else if constexpr (std::is_same_v<T, std::int32_t>)
    return Type::int32;
  else if constexpr (std::is_same_v<T, std::uint32_t>)
    return Type::uint32;
  else if constexpr (std::is_same_v<T, std::int64_t>)
    return Type::int64;
  else if constexpr (std::is_same_v<T, std::uint64_t>)
    return Type::uint64;
  else {
    static_assert(std::is_same_v<T, std::uint8_t>, "a type that our files do not store");
    return Type::uint8;
  }
}
std::size_t size_of(Type type); ///< bytes

/// One HDF5 identifier, closed on destruction.
class Handle {
public:
  Handle() = default;
  Handle(Id id, int (*close)(Id)) : id_(id), close_(close) {}
  Handle(Handle&& other) noexcept : id_(other.id_), close_(other.close_) { other.id_ = -1; }
  Handle& operator=(Handle&& other) noexcept {
    if (this != &other) {
      reset();
      id_ = other.id_, close_ = other.close_, other.id_ = -1;
    }
    return *this;
  }
  ~Handle() { reset(); }
  Id get() const { return id_; }
  /// Closes it; false where HDF5 could not.
  bool reset() noexcept {
    const bool good = id_ < 0 || close_(id_) >= 0;
    id_ = -1;
    return good;
  }

private:
  Id id_ = -1;
  int (*close_)(Id) = nullptr;
};

/// Where an object lies, for messages: "/VTKHDF/ball/Points of out/run.vtkhdf".
struct Place {
  std::string file, object;
};

/// What groups and datasets have in common: a place and attributes.
class Object {
public:
  Object(Handle handle, Place place) : handle_(std::move(handle)), place_(std::move(place)) {}
  const Place& place() const { return place_; }
  bool has_attribute(const std::string& name) const;
  /// Creates or overwrites; one value makes a scalar, more make a vector.
  template <class T> void set_attribute(const std::string& name, std::span<const T> values, bool scalar) {
    write_attribute(name, type_of<T>(), values.data(), values.size(), scalar);
  }
  template <class T> void set_attribute(const std::string& name, T value) {
    write_attribute(name, type_of<T>(), &value, 1, true);
  }
  /// Fixed-length ASCII of exactly the text's length, as VTK wants it.
  void set_text_attribute(const std::string& name, const std::string& text);
  template <class T> std::vector<T> attribute(const std::string& name) const {
    std::vector<T> values(attribute_size(name));
    read_attribute(name, type_of<T>(), values.data());
    return values;
  }
  std::string text_attribute(const std::string& name) const;

protected:
  Id id() const { return handle_.get(); }
  void write_attribute(const std::string& name, Type type, const void* values, std::size_t count,
                       bool scalar);
  std::size_t attribute_size(const std::string& name) const;
  void read_attribute(const std::string& name, Type type, void* values) const;
  Handle handle_;
  Place place_;
};

/// A table of `columns` values a row; columns 1 is a plain vector. Created ones are chunked and can grow.
class Dataset : public Object {
public:
  using Object::Object;
  std::uint64_t rows() const { return rows_; }
  std::uint64_t columns() const { return columns_; }
  /// Appends whole rows.
  template <class T> void append(std::span<const T> values) {
    append_raw(type_of<T>(), values.data(), values.size());
  }
  template <class T> void append(T value) { append_raw(type_of<T>(), &value, 1); }
  /// Rows first ... first + count.
  template <class T> std::vector<T> read(std::uint64_t first, std::uint64_t count) const {
    std::vector<T> values(count * columns_);
    read_raw(type_of<T>(), first, count, values.data());
    return values;
  }
  template <class T> std::vector<T> read() const { return read<T>(0, rows_); }
  /// Where the chunks that hold these rows lie in the file: offset and size, bytes. Only what was flushed.
  std::vector<std::array<std::uint64_t, 2>> chunks(std::uint64_t first, std::uint64_t count) const;

private:
  friend class Group;
  void append_raw(Type type, const void* values, std::size_t count);
  void read_raw(Type type, std::uint64_t first, std::uint64_t count, void* values) const;
  std::uint64_t rows_ = 0, columns_ = 1;
  bool flat_ = true; ///< rank 1
};

class Group : public Object {
public:
  using Object::Object;
  /// Creates a group, and those above it; the order of creation of its members is kept where asked.
  Group create_group(const std::string& name, bool keep_order = false);
  Group group(const std::string& name) const;
  bool has(const std::string& name) const;
  std::vector<std::string> names() const; ///< in order of creation where kept, else by name
  /// An empty dataset that grows by rows; `rank2` also where columns is 1. Chunks are of `chunk_rows` rows.
  Dataset create_dataset(const std::string& name, Type type, std::uint64_t columns, std::uint64_t chunk_rows,
                         bool rank2 = false);
  Dataset dataset(const std::string& name) const;
  /// A dataset of exactly these values.
  template <class T>
  void write(const std::string& name, std::span<const T> values, std::uint64_t columns = 1) {
    write_raw(name, type_of<T>(), values.data(), values.size(), columns);
  }
  template <class T> std::vector<T> read(const std::string& name) const { return dataset(name).read<T>(); }
  void soft_link(const std::string& name, const std::string& target);
  void remove(const std::string& name);
  /// A view of rows first ... first + rows of `source` in the same file, stored without a copy.
  void create_view(const std::string& name, Type type, const Dataset& source, std::uint64_t first,
                   std::uint64_t rows);

private:
  void write_raw(const std::string& name, Type type, const void* values, std::size_t count,
                 std::uint64_t columns);
};

/// A file opened without locks, so that others can look at it while it is written.
class File {
public:
  static File create(const std::filesystem::path& path); ///< replaces what is there
  static File open(const std::filesystem::path& path, bool writable = false);
  const std::string& name() const { return name_; }
  Group root() const;
  /// Hands everything to the operating system: what is killed afterwards leaves a readable file.
  void flush();
  /// Asks the file system for room for `bytes` more, before anything is written: a full disk is then an Error
  /// here, with the file as it was. Returns quietly where the file system cannot tell.
  void reserve(std::uint64_t bytes);
  /// Closes and reports what the destructor would have to swallow. All other objects of the file go first.
  void close();
  ~File();
  File(File&&) noexcept = default;
  File& operator=(File&&) noexcept = default;

private:
  File(Handle handle, std::string name, bool writable);
  Handle handle_;
  std::string name_;
  bool writable_ = false;
};

} // namespace pliant::h5
