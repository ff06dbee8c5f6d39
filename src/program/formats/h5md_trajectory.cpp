#include "formats/h5md_trajectory.hpp"

#include <fcntl.h>
#include <hdf5.h>
#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <utility>
#include <vector>

#include <tanor/error.hpp>
#include <tanor/version.hpp>

#include "report/frame_module.hpp"
#include "report/output_file.hpp"

namespace tanor::report {

namespace {

/// An identifier of HDF5, which is closed with this object.
class Handle {
 public:
  Handle() = default;
  Handle(hid_t id, herr_t (*close)(hid_t)) : id_(id), close_(close) {}
  Handle(Handle&& other) noexcept : id_(std::exchange(other.id_, -1)), close_(other.close_) {}
  Handle& operator=(Handle&& other) noexcept {
    std::swap(id_, other.id_);
    std::swap(close_, other.close_);
    return *this;
  }
  ~Handle() {
    if (id_ >= 0) close_(id_);
  }
  /// Leaves the identifier open for good.
  void abandon() { id_ = -1; }
  operator hid_t() const { return id_; }  // NOLINT: it stands for the identifier wherever HDF5 wants one

 private:
  hid_t id_ = -1;
  herr_t (*close_)(hid_t) = nullptr;
};

/// One array over time, with a row of numbers for each frame.
struct Series {
  Handle data;
  std::vector<hsize_t> shape;  ///< shape of one frame: {m, 3}, {R}, {}
  bool is_integer = false;
  hsize_t bytes_of_chunk = 0;
};

constexpr hsize_t room_for_groups = 1 << 18;  // more than everything except chunks and arrays of the points needs
constexpr hsize_t bytes_of_a_chunk = 1 << 16;
constexpr unsigned deflate_level = 4;

}  // namespace

struct H5mdTrajectory::File {
  std::string name;
  const ShownParts* shown;
  Handle file;
  std::uint64_t frames = 0;
  bool is_touched = false;  ///< by a frame that is not complete
  Series step, time, position, velocity, force, constraint_force, tension, energy, position_violation,
      velocity_violation;
  std::vector<Series> observed;  ///< of the scene

  explicit File(const std::filesystem::path& path, const ShownParts* the_shown)
      : name(path.string()), shown(the_shown) {
    H5dont_atexit();                              // each frame is flushed after it was written
    H5Eset_auto2(H5E_DEFAULT, nullptr, nullptr);  // errors are reported by this class
  }

  /// Throws with the system's reason if there is one, else with that of HDF5.
  [[noreturn]] void fail() const {
    const int reason = errno;
    std::string text;
    const auto take = [](unsigned, const H5E_error2_t* error, void* result) -> herr_t {
      *static_cast<std::string*>(result) = error->desc;  // the last one is the innermost
      return 0;
    };
    H5Ewalk2(H5E_DEFAULT, H5E_WALK_DOWNWARD, take, &text);
    throw WriteError(name, reason != 0 ? std::strerror(reason) : text.empty() ? "HDF5 failed" : text);
  }
  void check(herr_t status) const {
    if (status < 0) fail();
  }
  Handle check(hid_t id, herr_t (*close)(hid_t)) const {
    if (id < 0) fail();
    return {id, close};
  }

  /// Reserves room on the disk before HDF5 writes. If the disk were full during a write, HDF5's own state and the file
  /// would be lost.
  void reserve(hsize_t bytes) const {
    const int descriptor = ::open(name.c_str(), O_WRONLY | O_CLOEXEC);
    if (descriptor < 0) throw WriteError(name);
    const off_t size = lseek(descriptor, 0, SEEK_END);
    rlimit most{};
    getrlimit(RLIMIT_FSIZE, &most);
    const bool is_allowed = most.rlim_cur == RLIM_INFINITY || static_cast<rlim_t>(size) + bytes <= most.rlim_cur;
    int reason = is_allowed ? 0 : EFBIG;
    if (is_allowed && fallocate(descriptor, FALLOC_FL_KEEP_SIZE, size, static_cast<off_t>(bytes)) != 0) reason = errno;
    ::close(descriptor);
    // Not every file system can promise room.
    if (reason != 0 && reason != EOPNOTSUPP && reason != ENOSYS && reason != EINTR)
      throw WriteError(name, std::strerror(reason));
  }

  /// Returns the room for a new chunk of every series.
  hsize_t room_of_a_frame() {
    hsize_t room = room_for_groups;
    for (const Series* each : all_series()) room += each->bytes_of_chunk;
    return room;
  }

  /// Abandons all identifiers. After a failure HDF5 must not try again when it closes, because it would end the
  /// program.
  void abandon() {
    for (Series* each : all_series()) each->data.abandon();
    file.abandon();
  }

  Handle open_mode() const {
    Handle mode = check(H5Pcreate(H5P_FILE_ACCESS), H5Pclose);
    // Readers of a file that grows need the newest layout of the library that writes it.
    check(H5Pset_libver_bounds(mode, H5F_LIBVER_LATEST, H5F_LIBVER_LATEST));
    return mode;
  }

  Handle make_group(hid_t parent, const char* group) const {
    return check(H5Gcreate2(parent, group, H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT), H5Gclose);
  }

  void add_text(hid_t object, const char* attribute, const std::string& text) const {
    const Handle type = check(H5Tcopy(H5T_C_S1), H5Tclose), space = check(H5Screate(H5S_SCALAR), H5Sclose);
    check(H5Tset_size(type, std::max<std::size_t>(text.size(), 1)));
    check(H5Tset_cset(type, H5T_CSET_UTF8));
    const Handle made = check(H5Acreate2(object, attribute, type, space, H5P_DEFAULT, H5P_DEFAULT), H5Aclose);
    check(H5Awrite(made, type, text.empty() ? " " : text.data()));
  }

  void add_integers(hid_t object, const char* attribute, const std::vector<int>& values) const {
    const hsize_t size = values.size();
    const Handle space = check(size == 1 ? H5Screate(H5S_SCALAR) : H5Screate_simple(1, &size, nullptr), H5Sclose);
    const Handle made = check(H5Acreate2(object, attribute, H5T_STD_I32LE, space, H5P_DEFAULT, H5P_DEFAULT), H5Aclose);
    check(H5Awrite(made, H5T_NATIVE_INT, values.data()));
  }

  /// Adds an array that does not change.
  Handle add_fixed(hid_t group, const char* key, hid_t type_in_file, hid_t type, const std::vector<hsize_t>& shape,
                   const void* values) const {
    const Handle space = check(H5Screate_simple(static_cast<int>(shape.size()), shape.data(), nullptr), H5Sclose);
    Handle made = check(H5Dcreate2(group, key, type_in_file, space, H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT), H5Dclose);
    check(H5Dwrite(made, type, H5S_ALL, H5S_ALL, H5P_DEFAULT, values));
    return made;
  }

  Series add_series(hid_t group, const char* key, const std::vector<hsize_t>& shape, bool is_compressed,
                    bool is_integer = false) const {
    std::vector<hsize_t> size{0}, most{H5S_UNLIMITED}, chunk{1};
    hsize_t bytes = sizeof(double);
    for (const hsize_t extent : shape) {
      size.push_back(extent);
      most.push_back(extent);
      chunk.push_back(std::max<hsize_t>(extent, 1));
      bytes *= chunk.back();
    }
    chunk[0] = std::max<hsize_t>(1, bytes_of_a_chunk / bytes);
    constexpr hsize_t most_of_a_chunk = hsize_t{1} << 31;  // HDF5 allows less than 4 GiB
    if (bytes > most_of_a_chunk) chunk[1] = std::max<hsize_t>(1, chunk[1] / (bytes / most_of_a_chunk + 1));
    const Handle space = check(H5Screate_simple(static_cast<int>(size.size()), size.data(), most.data()), H5Sclose);
    const Handle how = check(H5Pcreate(H5P_DATASET_CREATE), H5Pclose);
    check(H5Pset_chunk(how, static_cast<int>(chunk.size()), chunk.data()));
    if (is_compressed) {
      check(H5Pset_shuffle(how));
      check(H5Pset_deflate(how, deflate_level));
    }
    return {
        check(H5Dcreate2(group, key, is_integer ? H5T_STD_I64LE : H5T_IEEE_F64LE, space, H5P_DEFAULT, how, H5P_DEFAULT),
              H5Dclose),
        shape, is_integer};
  }

  /// Adds {step, time, value} of H5MD; all elements share the steps and times of the first one.
  Series add_element(hid_t parent, const char* key, const std::vector<hsize_t>& shape, bool is_compressed) {
    const Handle group = make_group(parent, key);
    if (step.data < 0) {
      step = add_series(group, "step", {}, false, true);
      time = add_series(group, "time", {}, false);
    } else {
      check(H5Lcreate_hard(file, "/particles/all/position/step", group, "step", H5P_DEFAULT, H5P_DEFAULT));
      check(H5Lcreate_hard(file, "/particles/all/position/time", group, "time", H5P_DEFAULT, H5P_DEFAULT));
    }
    return add_series(group, "value", shape, is_compressed);
  }

  void add_box(hid_t particles, const std::optional<Cell>& cell) const {
    const Handle box = make_group(particles, "box");
    add_integers(box, "dimension", {3});
    const bool is_periodic[] = {cell && cell->xx > 0.0, cell && cell->yy > 0.0, cell && cell->zz > 0.0};
    constexpr hsize_t three = 3;
    const Handle type = check(H5Tcopy(H5T_C_S1), H5Tclose),
                 space = check(H5Screate_simple(1, &three, nullptr), H5Sclose);
    constexpr std::size_t width = 8;
    check(H5Tset_size(type, width));
    char words[3][width + 1] = {};
    std::string text;
    for (std::size_t k = 0; k < 3; ++k) {
      std::strcpy(words[k], is_periodic[k] ? "periodic" : "none");
      text.append(words[k], width);
    }
    const Handle boundary = check(H5Acreate2(box, "boundary", type, space, H5P_DEFAULT, H5P_DEFAULT), H5Aclose);
    check(H5Awrite(boundary, type, text.data()));
    if (!cell) return;
    add_fixed(box, "offset", H5T_IEEE_F64LE, H5T_NATIVE_DOUBLE, {3}, cell->origin.data());
    if (!cell->is_tilted()) {
      const double edges[] = {cell->xx, cell->yy, cell->zz};
      add_fixed(box, "edges", H5T_IEEE_F64LE, H5T_NATIVE_DOUBLE, {3}, edges);
    } else {  // one edge a row
      const double edges[] = {cell->xx, 0.0, 0.0, cell->xy, cell->yy, 0.0, cell->xz, cell->yz, cell->zz};
      add_fixed(box, "edges", H5T_IEEE_F64LE, H5T_NATIVE_DOUBLE, {3, 3}, edges);
    }
  }

  void add_particles(const Sample& sample) {
    const Handle parent = make_group(file, "particles"), all = make_group(parent, "all");
    add_box(all, sample.cell);
    const hsize_t m = shown->num_points;
    const std::vector<hsize_t> rows{m, 3};
    position = add_element(all, "position", rows, sample.is_compressed);
    velocity = add_element(all, "velocity", rows, sample.is_compressed);
    force = add_element(all, "force", rows, sample.is_compressed);
    constraint_force = add_element(all, "constraint_force", rows, sample.is_compressed);
    add_fixed(all, "mass", H5T_IEEE_F64LE, H5T_NATIVE_DOUBLE, {m}, sample.masses.data());
    const std::vector<int> ids(shown->points.begin(), shown->points.end()),
        species(shown->is_support.begin(), shown->is_support.end());
    add_fixed(all, "id", H5T_STD_I32LE, H5T_NATIVE_INT, {m}, ids.data());
    add_fixed(all, "species", H5T_STD_I32LE, H5T_NATIVE_INT, {m}, species.data());
    add_rods(all);
  }

  void add_rods(hid_t particles) const {
    if (shown->rods.empty()) return;
    std::vector<int> pairs;  // of the points' ids
    for (const auto& [i, j] : shown->rods) {
      const auto beyond = j - static_cast<std::int32_t>(shown->num_points);  // an image of a point
      for (const std::int32_t end : {i, beyond < 0 ? j : shown->images[static_cast<std::size_t>(beyond)].point})
        pairs.push_back(shown->points[static_cast<std::size_t>(end)]);
    }
    const Handle group = make_group(file, "connectivity");
    const Handle rods = add_fixed(group, "rods", H5T_STD_I32LE, H5T_NATIVE_INT, {shown->rods.size(), 2}, pairs.data());
    hobj_ref_t reference;
    check(H5Rcreate(&reference, particles, ".", H5R_OBJECT, -1));
    const Handle space = check(H5Screate(H5S_SCALAR), H5Sclose);
    const Handle made =
        check(H5Acreate2(rods, "particles_group", H5T_STD_REF_OBJ, space, H5P_DEFAULT, H5P_DEFAULT), H5Aclose);
    check(H5Awrite(made, H5T_STD_REF_OBJ, &reference));
  }

  /// Returns the name of an observable's group, in which '/' would begin another.
  static std::string group_of(const Observed& each) {
    std::string group = each.name;
    std::ranges::replace(group, '/', '|');
    return group == "tension" || group == "total_energy" || group.ends_with("_violation") ? "observed " + group : group;
  }
  static std::vector<hsize_t> shape_of(const Observed& each) {
    std::vector<hsize_t> shape;
    if (!each.members.empty()) shape.push_back(each.members.size());
    if (!each.parts.empty()) shape.push_back(each.parts.size());
    return shape;
  }
  void add_observed(hid_t group, const Observed& each, bool is_compressed) {
    observed.push_back(add_element(group, group_of(each).c_str(), shape_of(each), is_compressed));
    const auto join = [](const std::vector<std::string>& names) {
      std::string all;
      for (const std::string& word : names) all += (all.empty() ? "" : ",") + word;
      return all;
    };
    const hid_t value = observed.back().data;
    if (!each.unit.empty()) add_text(value, "unit", each.unit);
    if (each.text != each.name) add_text(value, "observable", each.text);
    if (!each.parts.empty()) add_text(value, "parts", join(each.parts));
    constexpr std::size_t most_of_an_attribute = 60000;  // bytes that HDF5 takes
    if (const std::string members = join(each.members); !members.empty() && members.size() < most_of_an_attribute)
      add_text(value, "members", members);
  }

  void add_observables(const Sample& sample) {
    const Handle group = make_group(file, "observables");
    for (const Observed& each : sample.observables) add_observed(group, each, sample.is_compressed);
    if (!shown->rods.empty()) tension = add_element(group, "tension", {shown->rods.size()}, sample.is_compressed);
    energy = add_element(group, "total_energy", {}, false);
    position_violation = add_element(group, "position_violation", {}, false);
    velocity_violation = add_element(group, "velocity_violation", {}, false);
  }

  void create(const Sample& sample) {
    errno = 0;
    file = check(H5Fcreate(name.c_str(), H5F_ACC_TRUNC, H5P_DEFAULT, open_mode()), H5Fclose);
    reserve(room_for_groups + 64 * (shown->num_points + shown->rods.size()));
    {
      const Handle h5md = make_group(file, "h5md"), author = make_group(h5md, "author"),
                   creator = make_group(h5md, "creator");
      add_integers(h5md, "version", {1, 1});
      add_text(author, "name", "user of tanor");
      add_text(creator, "name", "tanor");
      add_text(creator, "version", TANOR_VERSION);
      add_text(file, "title", sample.title);
      add_particles(sample);
      add_observables(sample);
    }
    check(H5Fstart_swmr_write(file));
    check(H5Fflush(file, H5F_SCOPE_LOCAL));  // a full disk is reported now, not when the file closes
  }

  /// Opens a file that is known to be ours, with the groups where `create` put them.
  void open(std::uint64_t frames_before, std::span<const Observed> observables) {
    errno = 0;
    {
      // A writer that was killed could not clear its mark.
      const Handle mode = open_mode();
      const hbool_t yes = true;
      check(H5Pset(mode, "clear_status_flags", &yes));
      file = check(H5Fopen(name.c_str(), H5F_ACC_RDWR, mode), H5Fclose);
    }
    const hsize_t m = shown->num_points;
    step = open_series("/particles/all/position/step", {}, true);
    time = open_series("/particles/all/position/time", {});
    position = open_series("/particles/all/position/value", {m, 3});
    velocity = open_series("/particles/all/velocity/value", {m, 3});
    force = open_series("/particles/all/force/value", {m, 3});
    constraint_force = open_series("/particles/all/constraint_force/value", {m, 3});
    if (!shown->rods.empty()) tension = open_series("/observables/tension/value", {shown->rods.size()});
    energy = open_series("/observables/total_energy/value", {});
    position_violation = open_series("/observables/position_violation/value", {});
    velocity_violation = open_series("/observables/velocity_violation/value", {});
    for (const Observed& each : observables)
      observed.push_back(open_series(("/observables/" + group_of(each) + "/value").c_str(), shape_of(each)));
    for (const Series* each : all_series()) {
      if (count_frames(*each) < frames_before)
        throw InputError(name, "has fewer frames than the checkpoint says; run without --resume");
    }
    resize(frames_before);
    check(H5Fstart_swmr_write(file));
  }

  Series open_series(const char* path, const std::vector<hsize_t>& shape, bool is_integer = false) const {
    Handle data(H5Dopen2(file, path, H5P_DEFAULT), H5Dclose);
    if (data < 0) throw InputError(name, std::string("has no ") + path + "; run without --resume");
    const Handle space(H5Dget_space(data), H5Sclose);
    std::vector<hsize_t> size(static_cast<std::size_t>(std::max(0, H5Sget_simple_extent_ndims(space))));
    if (!size.empty()) H5Sget_simple_extent_dims(space, size.data(), nullptr);
    if (size.empty() || !std::equal(size.begin() + 1, size.end(), shape.begin(), shape.end()))
      throw InputError(name, std::string("has another shape of ") + path + "; run without --resume");
    std::vector<hsize_t> chunk(size.size());
    const Handle how(H5Dget_create_plist(data), H5Pclose);
    if (H5Pget_chunk(how, static_cast<int>(chunk.size()), chunk.data()) < 0)
      throw InputError(name, std::string("has no chunks of ") + path + "; run without --resume");
    hsize_t bytes = sizeof(double);
    for (const hsize_t extent : chunk) bytes *= extent;
    return {std::move(data), shape, is_integer, bytes};
  }

  static std::uint64_t count_frames(const Series& series) {
    const Handle space(H5Dget_space(series.data), H5Sclose);
    std::vector<hsize_t> size(1 + series.shape.size());
    return H5Sget_simple_extent_dims(space, size.data(), nullptr) < 0 ? 0 : size[0];
  }

  std::vector<Series*> all_series() {
    std::vector<Series*> all{&position,           &velocity, &force, &constraint_force, &energy, &position_violation,
                             &velocity_violation, &time,     &step};
    if (tension.data >= 0) all.push_back(&tension);
    for (Series& each : observed) all.push_back(&each);
    return all;
  }

  void resize(std::uint64_t count) {
    for (const Series* each : all_series()) {
      std::vector<hsize_t> size{count};
      size.insert(size.end(), each->shape.begin(), each->shape.end());
      check(H5Dset_extent(each->data, size.data()));
    }
    check(H5Fflush(file, H5F_SCOPE_LOCAL));
    frames = count;
  }

  void append(const Series& series, const void* numbers) const {
    std::vector<hsize_t> size{frames + 1}, first{frames}, count{1};
    size.insert(size.end(), series.shape.begin(), series.shape.end());
    count.insert(count.end(), series.shape.begin(), series.shape.end());
    first.resize(size.size());
    check(H5Dset_extent(series.data, size.data()));
    const Handle in_file = check(H5Dget_space(series.data), H5Sclose),
                 in_memory = check(H5Screate_simple(static_cast<int>(count.size()), count.data(), nullptr), H5Sclose);
    check(H5Sselect_hyperslab(in_file, H5S_SELECT_SET, first.data(), nullptr, count.data(), nullptr));
    check(H5Dwrite(series.data, series.is_integer ? H5T_NATIVE_INT64 : H5T_NATIVE_DOUBLE, in_memory, in_file,
                   H5P_DEFAULT, numbers));
  }

  void append(const Frame& frame) {
    reserve(room_of_a_frame());
    is_touched = true;
    errno = 0;
    append(position, frame.positions.data());
    append(velocity, frame.velocities.data());
    append(force, frame.forces.data());
    append(constraint_force, frame.reactions.data());
    if (tension.data >= 0) append(tension, frame.tensions.data());
    append(energy, &frame.energy);
    append(position_violation, &frame.position_violation);
    append(velocity_violation, &frame.velocity_violation);
    for (std::size_t k = 0; k < observed.size(); ++k) append(observed[k], frame.observables[k].values.data());
    const auto steps = static_cast<std::int64_t>(frame.steps);
    append(time, &frame.time);
    append(step, &steps);
    check(H5Fflush(file, H5F_SCOPE_LOCAL));
    is_touched = false;
    ++frames;
  }
};

H5mdTrajectory::H5mdTrajectory(const std::filesystem::path& path, const ShownParts* shown, const Sample& sample)
    : file_(std::make_unique<File>(path, shown)) {
  try {
    file_->create(sample);
  } catch (const WriteError&) {  // the file has no frame, and no reader would accept it
    file_->abandon();
    remove_file(path);
    throw;
  }
}

H5mdTrajectory::H5mdTrajectory(const std::filesystem::path& path, const ShownParts* shown, std::uint64_t frames,
                               std::span<const Observed> observables)
    : file_(std::make_unique<File>(path, shown)) {
  file_->open(frames, observables);
}

H5mdTrajectory::~H5mdTrajectory() = default;

void H5mdTrajectory::write(const Frame& frame) {
  const std::uint64_t before = file_->frames;
  try {
    file_->append(frame);
  } catch (const WriteError&) {
    if (file_->is_touched) file_->abandon();
    file_->frames = before;
    throw;
  }
}

std::uint64_t H5mdTrajectory::mark() const {
  return file_->frames;
}

void H5mdTrajectory::cut(std::uint64_t frames) {
  file_->resize(frames);
}

void H5mdTrajectory::synchronize() {
  const int descriptor = ::open(file_->name.c_str(), O_RDONLY | O_CLOEXEC);
  const bool is_done = descriptor >= 0 && (fdatasync(descriptor) == 0 || errno == EINVAL);
  const int reason = errno;
  if (descriptor >= 0) ::close(descriptor);
  if (!is_done) throw WriteError(file_->name, std::strerror(reason));
}

}  // namespace tanor::report

/// The function of the module, which the program calls by its name.
extern "C" __attribute__((visibility("default"))) void tanor_open_frame_file(
    const tanor::report::FrameFileRequest& request, std::unique_ptr<tanor::report::FrameFile>* opened) {
  using tanor::report::H5mdTrajectory;
  if (request.frames > 0)
    *opened = std::make_unique<H5mdTrajectory>(request.path, request.shown, request.frames, request.observables);
  else
    *opened = std::make_unique<H5mdTrajectory>(request.path, request.shown,
                                               H5mdTrajectory::Sample{request.title, request.masses, request.cell,
                                                                      request.observables, request.is_compressed});
}
