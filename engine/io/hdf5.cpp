// Owning types over the C API of HDF5.
#include "engine/io/hdf5.h"

#include "engine/core/error.h"

#include <fmt/format.h>
#include <hdf5.h>

#include <array>
#include <cerrno>
#include <cstring>
#include <fcntl.h>
#include <sys/resource.h>
#include <sys/statvfs.h>
#include <unistd.h>

namespace pliant::h5 {

static_assert(std::is_same_v<hid_t, Id> || sizeof(hid_t) == sizeof(Id));

namespace {

int close_file(Id id) {
  return H5Fclose(id);
}
int close_group(Id id) {
  return H5Gclose(id);
}
int close_dataset(Id id) {
  return H5Dclose(id);
}
int close_space(Id id) {
  return H5Sclose(id);
}
int close_list(Id id) {
  return H5Pclose(id);
}
int close_attribute(Id id) {
  return H5Aclose(id);
}
int close_type(Id id) {
  return H5Tclose(id);
}

// Called before anything else of HDF5. Its work at exit is left out: it crashes (1.10) where a file could not
// be closed because the disk is full, and all that we open is closed by its owner.
void prepare_library() {
  static const bool done = [] {
    return H5dont_atexit() >= 0 && H5Eset_auto2(H5E_DEFAULT, nullptr, nullptr) >= 0;
  }();
  (void)done;
}

herr_t keep_innermost(unsigned, const H5E_error2_t* entry, void* text) {
  *static_cast<std::string*>(text) = entry->desc ? entry->desc : "";
  return 0;
}

// The reason at the bottom of HDF5's error stack; of its long lines about the operating system only errno's
// text.
std::string reason() {
  std::string text;
  H5Ewalk2(H5E_DEFAULT, H5E_WALK_DOWNWARD, keep_innermost, &text);
  const std::string key = "error message = '";
  if (const auto at = text.find(key); at != std::string::npos) {
    const auto end = text.find('\'', at + key.size());
    text = text.substr(at + key.size(), end - at - key.size());
  }
  return text.empty() ? "HDF5 gave no reason" : text;
}

std::string advice(const std::string& why) {
  if (why.find("No space left") != std::string::npos || why.find("quota") != std::string::npos ||
      why.find("File too large") != std::string::npos)
    return "; free some space or write to another place";
  return "";
}

[[noreturn]] void fail(const char* doing, const Place& place) {
  const std::string why = reason();
  throw Error(ExitCode::input_output,
              fmt::format("cannot {} {} of {}: {}{}", doing, place.object, place.file, why, advice(why)));
}

Handle own(Id id, int (*close)(Id), const char* doing, const Place& place) {
  if (id < 0) fail(doing, place);
  return Handle(id, close);
}

void check(int status, const char* doing, const Place& place) {
  if (status < 0) fail(doing, place);
}

// Our files are little-endian, in memory the machine's own order.
Id stored(Type type) {
  switch (type) {
  case Type::float32:
    return H5T_IEEE_F32LE;
  case Type::float64:
    return H5T_IEEE_F64LE;
  case Type::int32:
    return H5T_STD_I32LE;
  case Type::uint32:
    return H5T_STD_U32LE;
  case Type::int64:
    return H5T_STD_I64LE;
  case Type::uint64:
    return H5T_STD_U64LE;
  case Type::uint8:
    return H5T_STD_U8LE;
  }
  return -1;
}

Id native(Type type) {
  switch (type) {
  case Type::float32:
    return H5T_NATIVE_FLOAT;
  case Type::float64:
    return H5T_NATIVE_DOUBLE;
  case Type::int32:
    return H5T_NATIVE_INT32;
  case Type::uint32:
    return H5T_NATIVE_UINT32;
  case Type::int64:
    return H5T_NATIVE_INT64;
  case Type::uint64:
    return H5T_NATIVE_UINT64;
  case Type::uint8:
    return H5T_NATIVE_UINT8;
  }
  return -1;
}

Place below(const Place& place, const std::string& name) {
  if (!name.empty() && name.front() == '/') return {place.file, name};
  return {place.file, place.object == "/" ? "/" + name : place.object + "/" + name};
}

Handle space_of(std::uint64_t rows, std::uint64_t columns, bool flat, bool grows, const Place& place) {
  const std::array<hsize_t, 2> size = {rows, columns}, most = {H5S_UNLIMITED, columns};
  return own(H5Screate_simple(flat ? 1 : 2, size.data(), grows ? most.data() : nullptr), close_space,
             "describe", place);
}

void select(const Handle& space, std::uint64_t first, std::uint64_t rows, std::uint64_t columns,
            const Place& place) {
  const std::array<hsize_t, 2> start = {first, 0}, count = {rows, columns};
  check(H5Sselect_hyperslab(space.get(), H5S_SELECT_SET, start.data(), nullptr, count.data(), nullptr),
        "select rows", place);
}

// Times of creation are left out so that equal runs write equal bytes.
Handle dataset_list(const Place& place) {
  Handle list = own(H5Pcreate(H5P_DATASET_CREATE), close_list, "create", place);
  check(H5Pset_obj_track_times(list.get(), false), "create", place);
  return list;
}

Handle link_list(const Place& place) {
  Handle list = own(H5Pcreate(H5P_LINK_CREATE), close_list, "create", place);
  check(H5Pset_create_intermediate_group(list.get(), 1), "create", place);
  return list;
}

Handle access_list(const Place& place) {
  prepare_library();
  Handle list = own(H5Pcreate(H5P_FILE_ACCESS), close_list, "open", place);
  check(H5Pset_file_locking(list.get(), false, true), "open", place);
  return list;
}

} // namespace

std::size_t size_of(Type type) {
  switch (type) {
  case Type::float32:
  case Type::int32:
  case Type::uint32:
    return 4;
  case Type::float64:
  case Type::int64:
  case Type::uint64:
    return 8;
  case Type::uint8:
    return 1;
  }
  return 0;
}

// ---- attributes

bool Object::has_attribute(const std::string& name) const {
  return H5Aexists(id(), name.c_str()) > 0;
}

void Object::write_attribute(const std::string& name, Type type, const void* values, std::size_t count,
                             bool scalar) {
  const Place at = {place_.file, place_.object + "@" + name};
  Handle attribute;
  if (has_attribute(name)) {
    attribute = own(H5Aopen(id(), name.c_str(), H5P_DEFAULT), close_attribute, "open", at);
  } else {
    const Handle space = scalar ? own(H5Screate(H5S_SCALAR), close_space, "describe", at)
                                : space_of(count, 1, true, false, at);
    attribute = own(H5Acreate2(id(), name.c_str(), stored(type), space.get(), H5P_DEFAULT, H5P_DEFAULT),
                    close_attribute, "create", at);
  }
  check(H5Awrite(attribute.get(), native(type), values), "write", at);
}

void Object::set_text_attribute(const std::string& name, const std::string& text) {
  const Place at = {place_.file, place_.object + "@" + name};
  const Handle type = own(H5Tcopy(H5T_C_S1), close_type, "describe", at);
  check(H5Tset_size(type.get(), text.empty() ? 1 : text.size()), "describe", at);
  check(H5Tset_strpad(type.get(), H5T_STR_NULLPAD), "describe", at);
  const Handle space = own(H5Screate(H5S_SCALAR), close_space, "describe", at);
  if (has_attribute(name)) check(H5Adelete(id(), name.c_str()), "replace", at);
  const Handle attribute =
      own(H5Acreate2(id(), name.c_str(), type.get(), space.get(), H5P_DEFAULT, H5P_DEFAULT), close_attribute,
          "create", at);
  check(H5Awrite(attribute.get(), type.get(), text.c_str()), "write", at);
}

std::size_t Object::attribute_size(const std::string& name) const {
  const Place at = {place_.file, place_.object + "@" + name};
  const Handle attribute = own(H5Aopen(id(), name.c_str(), H5P_DEFAULT), close_attribute, "open", at);
  const Handle space = own(H5Aget_space(attribute.get()), close_space, "read", at);
  return static_cast<std::size_t>(H5Sget_simple_extent_npoints(space.get()));
}

void Object::read_attribute(const std::string& name, Type type, void* values) const {
  const Place at = {place_.file, place_.object + "@" + name};
  const Handle attribute = own(H5Aopen(id(), name.c_str(), H5P_DEFAULT), close_attribute, "open", at);
  check(H5Aread(attribute.get(), native(type), values), "read", at);
}

std::string Object::text_attribute(const std::string& name) const {
  const Place at = {place_.file, place_.object + "@" + name};
  const Handle attribute = own(H5Aopen(id(), name.c_str(), H5P_DEFAULT), close_attribute, "open", at);
  const Handle type = own(H5Aget_type(attribute.get()), close_type, "read", at);
  if (H5Tget_class(type.get()) != H5T_STRING || H5Tis_variable_str(type.get()) > 0)
    throw Error(ExitCode::input_output,
                fmt::format("{} of {} is not a fixed-length text", at.object, at.file));
  std::string text(H5Tget_size(type.get()), '\0');
  check(H5Aread(attribute.get(), type.get(), text.data()), "read", at);
  return text.substr(0, text.find('\0'));
}

// ---- datasets

void Dataset::append_raw(Type type, const void* values, std::size_t count) {
  if (count % columns_ != 0)
    throw Error(ExitCode::internal, fmt::format("{} values are no whole rows of {}", count, place_.object));
  const std::uint64_t added = count / columns_;
  if (added == 0) return;
  const std::array<hsize_t, 2> size = {rows_ + added, columns_};
  check(H5Dset_extent(id(), size.data()), "extend", place_);
  const Handle file_space = own(H5Dget_space(id()), close_space, "write", place_);
  select(file_space, rows_, added, columns_, place_);
  const Handle memory_space = space_of(added, columns_, flat_, false, place_);
  check(H5Dwrite(id(), native(type), memory_space.get(), file_space.get(), H5P_DEFAULT, values), "write",
        place_);
  rows_ += added;
}

void Dataset::read_raw(Type type, std::uint64_t first, std::uint64_t count, void* values) const {
  if (first + count > rows_)
    throw Error(ExitCode::input_output, fmt::format("{} of {} has {} rows, but rows {} to {} were sought",
                                                    place_.object, place_.file, rows_, first, first + count));
  if (count == 0) return;
  const Handle file_space = own(H5Dget_space(id()), close_space, "read", place_);
  select(file_space, first, count, columns_, place_);
  const Handle memory_space = space_of(count, columns_, flat_, false, place_);
  check(H5Dread(id(), native(type), memory_space.get(), file_space.get(), H5P_DEFAULT, values), "read",
        place_);
}

std::vector<std::array<std::uint64_t, 2>> Dataset::chunks(std::uint64_t first, std::uint64_t count) const {
  std::vector<std::array<std::uint64_t, 2>> found;
  const Handle list = own(H5Dget_create_plist(id()), close_list, "read", place_);
  std::array<hsize_t, 2> chunk = {1, 1};
  if (count == 0 || H5Pget_layout(list.get()) != H5D_CHUNKED ||
      H5Pget_chunk(list.get(), flat_ ? 1 : 2, chunk.data()) < 0)
    return found;
  for (hsize_t row = first / chunk[0] * chunk[0]; row < first + count; row += chunk[0]) {
    const std::array<hsize_t, 2> corner = {row, 0};
    unsigned filters = 0;
    haddr_t address = HADDR_UNDEF;
    hsize_t bytes = 0;
    check(H5Dget_chunk_info_by_coord(id(), corner.data(), &filters, &address, &bytes), "locate", place_);
    if (address != HADDR_UNDEF) found.push_back({address, bytes});
  }
  return found;
}

// ---- groups

Group Group::create_group(const std::string& name, bool keep_order) {
  const Place at = below(place_, name);
  const Handle list = own(H5Pcreate(H5P_GROUP_CREATE), close_list, "create", at);
  if (keep_order)
    check(H5Pset_link_creation_order(list.get(), H5P_CRT_ORDER_TRACKED | H5P_CRT_ORDER_INDEXED), "create",
          at);
  check(H5Pset_obj_track_times(list.get(), false), "create", at);
  return {own(H5Gcreate2(id(), name.c_str(), link_list(at).get(), list.get(), H5P_DEFAULT), close_group,
              "create", at),
          at};
}

Group Group::group(const std::string& name) const {
  const Place at = below(place_, name);
  return {own(H5Gopen2(id(), name.c_str(), H5P_DEFAULT), close_group, "open", at), at};
}

bool Group::has(const std::string& name) const {
  // H5Lexists fails, rather than says no, where a group on the way is missing.
  for (auto at = name.find('/', 1); at != std::string::npos; at = name.find('/', at + 1))
    if (H5Lexists(id(), name.substr(0, at).c_str(), H5P_DEFAULT) <= 0) return false;
  return H5Lexists(id(), name.c_str(), H5P_DEFAULT) > 0;
}

std::vector<std::string> Group::names() const {
  H5G_info_t info;
  check(H5Gget_info(id(), &info), "list", place_);
  const Handle list = own(H5Gget_create_plist(id()), close_list, "list", place_);
  unsigned order = 0;
  check(H5Pget_link_creation_order(list.get(), &order), "list", place_);
  const H5_index_t index = order & H5P_CRT_ORDER_TRACKED ? H5_INDEX_CRT_ORDER : H5_INDEX_NAME;
  std::vector<std::string> names;
  for (hsize_t i = 0; i < info.nlinks; ++i) {
    const ssize_t length = H5Lget_name_by_idx(id(), ".", index, H5_ITER_INC, i, nullptr, 0, H5P_DEFAULT);
    if (length < 0) fail("list", place_);
    std::string name(static_cast<std::size_t>(length) + 1, '\0');
    H5Lget_name_by_idx(id(), ".", index, H5_ITER_INC, i, name.data(), name.size(), H5P_DEFAULT);
    name.pop_back();
    names.push_back(std::move(name));
  }
  return names;
}

Dataset Group::create_dataset(const std::string& name, Type type, std::uint64_t columns,
                              std::uint64_t chunk_rows, bool rank2) {
  const Place at = below(place_, name);
  const bool flat = columns == 1 && !rank2;
  const Handle list = dataset_list(at);
  const std::array<hsize_t, 2> chunk = {std::max<std::uint64_t>(chunk_rows, 1), columns};
  check(H5Pset_chunk(list.get(), flat ? 1 : 2, chunk.data()), "create", at);
  const Handle space = space_of(0, columns, flat, true, at);
  Dataset made(own(H5Dcreate2(id(), name.c_str(), stored(type), space.get(), link_list(at).get(), list.get(),
                              H5P_DEFAULT),
                   close_dataset, "create", at),
               at);
  made.columns_ = columns, made.flat_ = flat;
  return made;
}

Dataset Group::dataset(const std::string& name) const {
  const Place at = below(place_, name);
  Dataset found(own(H5Dopen2(id(), name.c_str(), H5P_DEFAULT), close_dataset, "open", at), at);
  const Handle space = own(H5Dget_space(found.id()), close_space, "read", at);
  const int rank = H5Sget_simple_extent_ndims(space.get());
  if (rank != 1 && rank != 2)
    throw Error(ExitCode::input_output, fmt::format("{} of {} is no vector or table", at.object, at.file));
  std::array<hsize_t, 2> size = {0, 1};
  H5Sget_simple_extent_dims(space.get(), size.data(), nullptr);
  found.rows_ = size[0], found.columns_ = size[1], found.flat_ = rank == 1;
  return found;
}

void Group::write_raw(const std::string& name, Type type, const void* values, std::size_t count,
                      std::uint64_t columns) {
  const Place at = below(place_, name);
  const Handle space = space_of(count / columns, columns, columns == 1, false, at);
  const Handle made = own(H5Dcreate2(id(), name.c_str(), stored(type), space.get(), link_list(at).get(),
                                     dataset_list(at).get(), H5P_DEFAULT),
                          close_dataset, "create", at);
  if (count > 0)
    check(H5Dwrite(made.get(), native(type), H5S_ALL, H5S_ALL, H5P_DEFAULT, values), "write", at);
}

void Group::soft_link(const std::string& name, const std::string& target) {
  const Place at = below(place_, name);
  check(H5Lcreate_soft(target.c_str(), id(), name.c_str(), link_list(at).get(), H5P_DEFAULT), "link", at);
}

void Group::remove(const std::string& name) {
  check(H5Ldelete(id(), name.c_str(), H5P_DEFAULT), "remove", below(place_, name));
}

void Group::create_view(const std::string& name, Type type, const Dataset& source, std::uint64_t first,
                        std::uint64_t rows) {
  const Place at = below(place_, name);
  const Handle own_space = space_of(rows, source.columns_, source.flat_, false, at);
  const Handle source_space = space_of(source.rows_, source.columns_, source.flat_, true, at);
  select(source_space, first, rows, source.columns_, at);
  const Handle list = dataset_list(at);
  check(H5Pset_virtual(list.get(), own_space.get(), ".", source.place_.object.c_str(), source_space.get()),
        "map", at);
  const Handle made = own(H5Dcreate2(id(), name.c_str(), stored(type), own_space.get(), link_list(at).get(),
                                     list.get(), H5P_DEFAULT),
                          close_dataset, "create", at);
}

// ---- files

File::File(Handle handle, std::string name, bool writable)
    : handle_(std::move(handle)), name_(std::move(name)), writable_(writable) {}

File File::create(const std::filesystem::path& path) {
  const Place at = {path.string(), "the root"};
  const Handle access = access_list(at);
  const Handle list = own(H5Pcreate(H5P_FILE_CREATE), close_list, "create", at);
  check(H5Pset_obj_track_times(list.get(), false), "create", at);
  return {own(H5Fcreate(at.file.c_str(), H5F_ACC_TRUNC, list.get(), access.get()), close_file, "create", at),
          at.file, true};
}

File File::open(const std::filesystem::path& path, bool writable) {
  const Place at = {path.string(), "the root"};
  const Handle access = access_list(at);
  return {own(H5Fopen(at.file.c_str(), writable ? H5F_ACC_RDWR : H5F_ACC_RDONLY, access.get()), close_file,
              "open", at),
          at.file, writable};
}

Group File::root() const {
  const Place at = {name_, "/"};
  return {own(H5Gopen2(handle_.get(), "/", H5P_DEFAULT), close_group, "open", at), at};
}

void File::flush() {
  check(H5Fflush(handle_.get(), H5F_SCOPE_GLOBAL), "flush", {name_, "the contents"});
}

void File::reserve(std::uint64_t bytes) {
  const auto refuse = [&](int number) {
    const std::string why = std::strerror(number);
    throw Error(ExitCode::input_output,
                fmt::format("cannot add {} bytes to {}: {}{}; what was written before is intact", bytes,
                            name_, why, advice(why)));
  };
  void* descriptor = nullptr;
  if (H5Fget_vfd_handle(handle_.get(), H5P_DEFAULT, &descriptor) < 0 || !descriptor) return;
  const int file = *static_cast<int*>(descriptor);
  const off_t end = ::lseek(file, 0, SEEK_END);
  rlimit limit;
  if (::getrlimit(RLIMIT_FSIZE, &limit) == 0 && limit.rlim_cur != RLIM_INFINITY &&
      static_cast<std::uint64_t>(end) + bytes > limit.rlim_cur)
    refuse(EFBIG);
#ifdef __linux__
  if (::fallocate(file, FALLOC_FL_KEEP_SIZE, end, static_cast<off_t>(bytes)) == 0) return;
  if (errno == ENOSPC || errno == EDQUOT || errno == EFBIG) refuse(errno);
#endif
  struct statvfs room;
  if (::fstatvfs(file, &room) == 0 && static_cast<std::uint64_t>(room.f_bavail) * room.f_frsize < bytes)
    refuse(ENOSPC);
}

void File::close() {
  if (handle_.get() < 0) return;
  if (writable_) {
    flush();
    // Setting the size that it has gives back what reserve() took beyond it.
    void* descriptor = nullptr;
    if (H5Fget_vfd_handle(handle_.get(), H5P_DEFAULT, &descriptor) >= 0 && descriptor) {
      const int file = *static_cast<int*>(descriptor);
      if (::ftruncate(file, ::lseek(file, 0, SEEK_END)) != 0)
        throw Error(ExitCode::input_output, fmt::format("cannot close {}: {}", name_, std::strerror(errno)));
    }
  }
  if (!handle_.reset()) fail("close", {name_, "the file"});
}

File::~File() = default;

} // namespace pliant::h5
