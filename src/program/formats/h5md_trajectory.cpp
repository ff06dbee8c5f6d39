#include <fcntl.h>
#include <hdf5.h>
#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <functional>
#include <memory>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include <tanor/error.hpp>
#include <tanor/version.hpp>

#include "report/frame_file.hpp"
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

/// An array over time: its path, the shape of one frame, {m, 3}, {R} or {}, and its numbers in a frame.
struct Element {
  std::string path;
  std::vector<hsize_t> shape;
  bool is_large = false;    ///< compressed if the user wants that
  bool is_integer = false;  ///< of 64 bits; else doubles
  std::function<const void*(const Frame&)> numbers{};
  Dimension dimension = Dimension::None;
};

/// Such an array in the file, with a row for each frame.
struct Series {
  Handle data;
  Element element;
  hsize_t bytes_of_chunk = 0;
};

constexpr hsize_t room_for_groups = 1 << 18;  // more than everything except chunks and arrays of the points needs
constexpr hsize_t bytes_of_a_chunk = 1 << 16;
constexpr unsigned deflate_level = 4;

/// An H5MD file (version 1.1, de Buyl, Colberg and Höfling, Comput. Phys. Commun. 185 (2014) 1546; MDAnalysis, OVITO,
/// VMD, h5py): `/particles/all` with box, mass, id, species (0: moves, 1: support), position, velocity, force (M w) and
/// constraint_force (K lambda); `/connectivity/rods`, pairs of rows of `/particles/all`; `/observables`: tension (a
/// number a rod), total_energy, position_violation, velocity_violation, and those of the scene, with `unit` and
/// the lists `parts` and `members`.
///
/// The file is written in HDF5's mode for a single writer and many readers: each frame is complete before the file
/// counts it, and h5py opens it with `swmr=True` while the run goes on. A run that was killed leaves a mark in the file
/// that plain readers refuse; `h5clear -s` or a resumed run removes it.
class H5mdTrajectory : public FrameFile {
 public:
  explicit H5mdTrajectory(const FrameFileRequest& request)
      : name_(request.path.string()),
        shown_(request.shown),
        has_cell_(request.cell.has_value()),
        edges_(edges_of(request.cell.value_or(Cell{}))) {
    H5dont_atexit();                              // each frame is flushed after it was written
    H5Eset_auto2(H5E_DEFAULT, nullptr, nullptr);  // errors are reported by this class
    try {
      request.mark > 0 ? open(request) : create(request);
    } catch (const WriteError&) {
      if (request.mark > 0) throw;
      abandon();  // the file has no frame, and no reader would accept it
      remove_file(request.path);
      throw;
    }
  }

  void write(const Frame& frame) override {
    const std::uint64_t before = frames_;
    try {
      append(frame);
    } catch (const WriteError&) {
      if (is_touched_) abandon();
      frames_ = before;
      throw;
    }
  }
  std::uint64_t mark() const override { return frames_; }
  void cut(std::uint64_t frames) override { resize(frames); }
  void synchronize() override {
    const int descriptor = ::open(name_.c_str(), O_RDONLY | O_CLOEXEC);
    const bool is_done = descriptor >= 0 && (fdatasync(descriptor) == 0 || errno == EINVAL);
    const int reason = errno;
    if (descriptor >= 0) ::close(descriptor);
    if (!is_done) throw WriteError(name_, std::strerror(reason));
  }

 private:
  /// Throws with the system's reason if there is one, else with that of HDF5.
  [[noreturn]] void fail() const {
    const int reason = errno;
    std::string text;
    const auto take = [](unsigned, const H5E_error2_t* error, void* result) -> herr_t {
      *static_cast<std::string*>(result) = error->desc;  // the last one is the innermost
      return 0;
    };
    H5Ewalk2(H5E_DEFAULT, H5E_WALK_DOWNWARD, take, &text);
    throw WriteError(name_, reason != 0 ? std::strerror(reason) : text.empty() ? "HDF5 failed" : text);
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
    const int descriptor = ::open(name_.c_str(), O_WRONLY | O_CLOEXEC);
    if (descriptor < 0) throw WriteError(name_);
    const off_t size = lseek(descriptor, 0, SEEK_END);
    rlimit most{};
    getrlimit(RLIMIT_FSIZE, &most);
    const bool is_allowed = most.rlim_cur == RLIM_INFINITY || static_cast<rlim_t>(size) + bytes <= most.rlim_cur;
    int reason = is_allowed ? 0 : EFBIG;
    if (is_allowed && fallocate(descriptor, FALLOC_FL_KEEP_SIZE, size, static_cast<off_t>(bytes)) != 0) reason = errno;
    ::close(descriptor);
    // Not every file system can promise room.
    if (reason != 0 && reason != EOPNOTSUPP && reason != ENOSYS && reason != EINTR)
      throw WriteError(name_, std::strerror(reason));
  }

  /// Returns the room for a new chunk of every series.
  hsize_t room_of_a_frame() const {
    hsize_t room = room_for_groups;
    for (const Series& each : series_) room += each.bytes_of_chunk;
    return room;
  }

  /// Abandons all identifiers. After a failure HDF5 must not try again when it closes, because it would end the
  /// program.
  void abandon() {
    for (Series& each : series_) each.data.abandon();
    file_.abandon();
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

  /// Adds a list of texts, such as names, which may hold any letters.
  void add_texts(hid_t object, const char* attribute, const std::vector<std::string>& texts) const {
    if (texts.empty()) return;
    const hsize_t count = texts.size();
    const std::size_t width = std::max<std::size_t>(1, std::ranges::max(texts, {}, &std::string::size).size());
    const Handle type = check(H5Tcopy(H5T_C_S1), H5Tclose),
                 space = check(H5Screate_simple(1, &count, nullptr), H5Sclose);
    check(H5Tset_size(type, width));
    check(H5Tset_strpad(type, H5T_STR_NULLPAD));
    check(H5Tset_cset(type, H5T_CSET_UTF8));
    std::string all;
    for (const std::string& each : texts) all.append(each).resize(all.size() + width - each.size());
    const Handle made = check(H5Acreate2(object, attribute, type, space, H5P_DEFAULT, H5P_DEFAULT), H5Aclose);
    check(H5Awrite(made, type, all.data()));
  }

  void add_integers(hid_t object, const char* attribute, const std::vector<int>& values) const {
    const hsize_t size = values.size();
    const Handle space = check(size == 1 ? H5Screate(H5S_SCALAR) : H5Screate_simple(1, &size, nullptr), H5Sclose);
    const Handle made = check(H5Acreate2(object, attribute, H5T_STD_I32LE, space, H5P_DEFAULT, H5P_DEFAULT), H5Aclose);
    check(H5Awrite(made, H5T_NATIVE_INT, values.data()));
  }

  /// Adds an array of doubles or of integers that does not change.
  template <class Number>
  Handle add_fixed(hid_t group, const char* key, const std::vector<hsize_t>& shape, const Number* values) const {
    constexpr bool is_double = std::is_same_v<Number, double>;
    const Handle space = check(H5Screate_simple(static_cast<int>(shape.size()), shape.data(), nullptr), H5Sclose);
    Handle made = check(H5Dcreate2(group, key, is_double ? H5T_IEEE_F64LE : H5T_STD_I32LE, space, H5P_DEFAULT,
                                   H5P_DEFAULT, H5P_DEFAULT),
                        H5Dclose);
    check(H5Dwrite(made, is_double ? H5T_NATIVE_DOUBLE : H5T_NATIVE_INT, H5S_ALL, H5S_ALL, H5P_DEFAULT, values));
    return made;
  }

  /// Makes an array with a row for each frame.
  void add_series(const Element& element, bool may_be_compressed) {
    std::vector<hsize_t> size{0}, most{H5S_UNLIMITED}, chunk{1};
    hsize_t bytes = sizeof(double);
    for (const hsize_t extent : element.shape) {
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
    if (may_be_compressed && element.is_large) {
      check(H5Pset_shuffle(how));
      check(H5Pset_deflate(how, deflate_level));
    }
    const hid_t type = element.is_integer ? H5T_STD_I64LE : H5T_IEEE_F64LE;
    series_.push_back(
        {check(H5Dcreate2(file_, element.path.c_str(), type, space, H5P_DEFAULT, how, H5P_DEFAULT), H5Dclose),
         element});
    // MDAnalysis refuses an attribute `unit` that it does not know, such as m, of all that it reads.
    add_unit(series_.back().data, element.path.starts_with("/particles/") ? "units" : "unit", element.dimension);
  }

  void add_unit(hid_t object, const char* attribute, Dimension dimension) const {
    if (const std::string letters = shown_->units.letters(dimension); !letters.empty())
      add_text(object, attribute, letters);
  }

  /// Returns the arrays over time, each in a group {step, time, value} of H5MD of its own. All share the steps and
  /// times of the first group.
  std::vector<Element> list_elements(std::span<const Observed> observables) const {
    using Numbers = std::span<const double> Frame::*;
    const std::vector<hsize_t> rows{shown_->num_points, 3}, rods{shown_->rods.size()};
    const std::string first(first_group);
    std::vector<Element> elements{
        {first + "/step", {}, false, true, [](const Frame& frame) { return &frame.steps; }},
        {first + "/time", {}, false, false, [](const Frame& frame) { return &frame.time; }, Dimension::Time}};
    const auto add = [&](const std::string& group, const std::vector<hsize_t>& shape, Numbers numbers,
                         Dimension dimension) {
      const auto read = [numbers](const Frame& frame) { return (frame.*numbers).data(); };
      elements.push_back({group + "/value", shape, true, false, read, dimension});
    };
    add(first, rows, &Frame::positions, Dimension::Length);
    // MDAnalysis reads matrices over time alone.
    if (has_cell_)
      elements.push_back({"/particles/all/box/edges/value",
                          {3, 3},
                          false,
                          false,
                          [this](const Frame&) { return edges_.data(); },
                          Dimension::Length});
    add("/particles/all/velocity", rows, &Frame::velocities, Dimension::Velocity);
    add("/particles/all/force", rows, &Frame::forces, Dimension::Forces);
    add("/particles/all/constraint_force", rows, &Frame::reactions, Dimension::Forces);
    const std::vector<std::string> groups = groups_of(observables);
    for (std::size_t k = 0; k < observables.size(); ++k) {
      std::vector<hsize_t> shape;
      if (!observables[k].members.empty()) shape.push_back(observables[k].members.size());
      if (!observables[k].parts.empty()) shape.push_back(observables[k].parts.size());
      elements.push_back({groups[k] + "/value", shape, true, false,
                          [k](const Frame& frame) { return frame.observables[k].values.data(); }});
    }
    if (!shown_->rods.empty()) add("/observables/tension", rods, &Frame::tensions, Dimension::Forces);
    const auto add_number = [&](const std::string& name, double Frame::*number, Dimension dimension) {
      const auto read = [number](const Frame& frame) { return &(frame.*number); };
      elements.push_back({"/observables/" + name + "/value", {}, false, false, read, dimension});
    };
    add_number("total_energy", &Frame::energy, Dimension::Energy);
    add_number("position_violation", &Frame::position_violation, Dimension::None);
    add_number("velocity_violation", &Frame::velocity_violation, Dimension::None);
    return elements;
  }

  void add_elements(const FrameFileRequest& request) {
    for (const Element& each : list_elements(request.observables)) {
      const std::string group = each.path.substr(0, each.path.rfind('/'));
      if (series_.empty() || group != first_group) make_group(file_, group.c_str());
      if (group != first_group) {
        for (const char* key : {"/step", "/time"})
          check(H5Lcreate_hard(file_, (first_group + std::string(key)).c_str(), file_, (group + key).c_str(),
                               H5P_DEFAULT, H5P_DEFAULT));
      }
      add_series(each, request.is_compressed);
      if (group == "/observables/tension") add_texts(series_.back().data, "members", shown_->rod_names());
    }
  }

  void add_box(hid_t particles, const std::optional<Cell>& cell) const {
    const Handle box = make_group(particles, "box");
    add_integers(box, "dimension", {3});
    const bool is_periodic[] = {cell && cell->xx > 0.0, cell && cell->yy > 0.0, cell && cell->zz > 0.0};
    std::vector<std::string> words;
    for (const bool is : is_periodic) words.emplace_back(is ? "periodic" : "none");
    add_texts(box, "boundary", words);
    if (!cell) return;
    add_unit(add_fixed(box, "offset", {3}, cell->origin.data()), "units", Dimension::Length);
  }

  void add_particles(const FrameFileRequest& request) {
    const Handle parent = make_group(file_, "particles"), all = make_group(parent, "all");
    add_box(all, request.cell);
    const hsize_t m = shown_->num_points;
    add_unit(add_fixed(all, "mass", {m}, request.masses.data()), "units", Dimension::Mass);
    const std::vector<int> ids(shown_->points.begin(), shown_->points.end()),
        species(shown_->is_support.begin(), shown_->is_support.end());
    add_fixed(all, "id", {m}, ids.data());
    add_fixed(all, "species", {m}, species.data());
    add_rods(all);
  }

  void add_rods(hid_t particles) const {
    if (shown_->rods.empty()) return;
    const std::vector<std::array<Index, 2>> pairs = shown_->rod_points();
    const Handle group = make_group(file_, "connectivity");
    const Handle rods = add_fixed(group, "rods", {pairs.size(), 2}, pairs.front().data());
    hobj_ref_t reference;
    check(H5Rcreate(&reference, particles, ".", H5R_OBJECT, -1));
    const Handle space = check(H5Screate(H5S_SCALAR), H5Sclose);
    const Handle made =
        check(H5Acreate2(rods, "particles_group", H5T_STD_REF_OBJ, space, H5P_DEFAULT, H5P_DEFAULT), H5Aclose);
    check(H5Awrite(made, H5T_STD_REF_OBJ, &reference));
  }

  /// Returns the groups of observables, in whose names '/' would begin another. Each has its own.
  static std::vector<std::string> groups_of(std::span<const Observed> observables) {
    std::vector<std::string> groups;
    for (const Observed& each : observables) {
      std::string name = each.name;
      std::ranges::replace_if(
          name, [](char c) { return c == '/' || c == '\0'; }, '|');
      const auto is_taken = [&] {
        return name == "." || name == "tension" || name == "total_energy" || name == "position_violation" ||
               name == "velocity_violation" || std::ranges::count(groups, "/observables/" + name) > 0;
      };
      while (is_taken()) name = "observed " + name;
      groups.push_back("/observables/" + name);
    }
    return groups;
  }
  void add_words(const Observed& each, const std::string& group) const {
    const Handle value = check(H5Dopen2(file_, (group + "/value").c_str(), H5P_DEFAULT), H5Dclose);
    if (!each.unit.empty()) add_text(value, "unit", each.unit);
    if (!group.ends_with("/" + each.text)) add_text(value, "observable", each.text);
    add_texts(value, "parts", each.parts);
    add_texts(value, "members", each.members);
  }

  void create(const FrameFileRequest& request) {
    errno = 0;
    file_ = check(H5Fcreate(name_.c_str(), H5F_ACC_TRUNC, H5P_DEFAULT, open_mode()), H5Fclose);
    reserve(room_for_groups + 128 * (shown_->num_points + shown_->rods.size()));
    {
      const Handle h5md = make_group(file_, "h5md"), author = make_group(h5md, "author"),
                   creator = make_group(h5md, "creator");
      add_integers(h5md, "version", {1, 1});
      add_text(author, "name", "user of tanor");
      add_text(creator, "name", "tanor");
      add_text(creator, "version", TANOR_VERSION);
      add_text(file_, "title", request.title);
      add_particles(request);
      make_group(file_, "observables");
      add_elements(request);
      const std::vector<std::string> groups = groups_of(request.observables);
      for (std::size_t k = 0; k < groups.size(); ++k) add_words(request.observables[k], groups[k]);
    }
    check(H5Fstart_swmr_write(file_));
    check(H5Fflush(file_, H5F_SCOPE_LOCAL));  // a full disk is reported now, not when the file closes
  }

  /// Opens a file that is known to be ours, with the groups where `create` put them.
  void open(const FrameFileRequest& request) {
    errno = 0;
    {
      // A writer that was killed could not clear its mark.
      const Handle mode = open_mode();
      const hbool_t yes = true;
      check(H5Pset(mode, "clear_status_flags", &yes));
      file_ = check(H5Fopen(name_.c_str(), H5F_ACC_RDWR, mode), H5Fclose);
    }
    for (const Element& each : list_elements(request.observables)) open_series(each);
    for (const Series& each : series_) {
      if (count_frames(each) < request.mark)
        throw InputError(name_, "has fewer frames than the checkpoint says; run without --resume");
    }
    resize(request.mark);
    check(H5Fstart_swmr_write(file_));
  }

  void open_series(const Element& element) {
    const auto& [path, shape, is_large, is_integer, numbers, dimension] = element;
    Handle data(H5Dopen2(file_, path.c_str(), H5P_DEFAULT), H5Dclose);
    if (data < 0) throw InputError(name_, "has no " + path + "; run without --resume");
    const Handle space(H5Dget_space(data), H5Sclose);
    std::vector<hsize_t> size(static_cast<std::size_t>(std::max(0, H5Sget_simple_extent_ndims(space))));
    if (!size.empty()) H5Sget_simple_extent_dims(space, size.data(), nullptr);
    if (size.empty() || !std::equal(size.begin() + 1, size.end(), shape.begin(), shape.end()))
      throw InputError(name_, "has another shape of " + path + "; run without --resume");
    std::vector<hsize_t> chunk(size.size());
    const Handle how(H5Dget_create_plist(data), H5Pclose);
    if (H5Pget_chunk(how, static_cast<int>(chunk.size()), chunk.data()) < 0)
      throw InputError(name_, "has no chunks of " + path + "; run without --resume");
    hsize_t bytes = sizeof(double);
    for (const hsize_t extent : chunk) bytes *= extent;
    series_.push_back({std::move(data), element, bytes});
  }

  static std::uint64_t count_frames(const Series& series) {
    const Handle space(H5Dget_space(series.data), H5Sclose);
    std::vector<hsize_t> size(1 + series.element.shape.size());
    return H5Sget_simple_extent_dims(space, size.data(), nullptr) < 0 ? 0 : size[0];
  }

  void resize(std::uint64_t count) {
    for (const Series& each : series_) {
      std::vector<hsize_t> size{count};
      size.insert(size.end(), each.element.shape.begin(), each.element.shape.end());
      check(H5Dset_extent(each.data, size.data()));
    }
    check(H5Fflush(file_, H5F_SCOPE_LOCAL));
    frames_ = count;
  }

  void append(const Series& series, const Frame& frame) const {
    const std::vector<hsize_t>& shape = series.element.shape;
    std::vector<hsize_t> size{frames_ + 1}, first{frames_}, count{1};
    for (std::vector<hsize_t>* each : {&size, &count}) each->insert(each->end(), shape.begin(), shape.end());
    first.resize(size.size());
    check(H5Dset_extent(series.data, size.data()));
    const Handle in_file = check(H5Dget_space(series.data), H5Sclose),
                 in_memory = check(H5Screate_simple(static_cast<int>(count.size()), count.data(), nullptr), H5Sclose);
    check(H5Sselect_hyperslab(in_file, H5S_SELECT_SET, first.data(), nullptr, count.data(), nullptr));
    check(H5Dwrite(series.data, series.element.is_integer ? H5T_NATIVE_INT64 : H5T_NATIVE_DOUBLE, in_memory, in_file,
                   H5P_DEFAULT, series.element.numbers(frame)));
  }

  void append(const Frame& frame) {
    reserve(room_of_a_frame());
    is_touched_ = true;
    errno = 0;
    // Readers count the steps, which are therefore written last.
    for (auto each = series_.rbegin(); each != series_.rend(); ++each) append(*each, frame);
    check(H5Fflush(file_, H5F_SCOPE_LOCAL));
    is_touched_ = false;
    ++frames_;
  }

  static constexpr const char* first_group = "/particles/all/position";

  std::string name_;
  const ShownParts* shown_;
  bool has_cell_;
  std::array<double, 9> edges_;  ///< of the cell, one a row
  Handle file_;
  std::uint64_t frames_ = 0;
  bool is_touched_ = false;  ///< by a frame that is not complete
  std::vector<Series> series_;
};

}  // namespace

}  // namespace tanor::report

/// The function of the module, which the program calls by its name.
extern "C" __attribute__((visibility("default"))) void tanor_open_frame_file(
    const tanor::report::FrameFileRequest& request, std::unique_ptr<tanor::report::FrameFile>* opened) {
  *opened = std::make_unique<tanor::report::H5mdTrajectory>(request);
}
