/// Calls <tanor.h> in any order with any numbers, as a host in C may do: the bytes of an input are the calls. Pointers
/// are right or null and arrays as long as the header says; all else may be wrong. A call returns a code, an array that
/// it
/// refused is unchanged, and what it calls good has no NaN.

#include <tanor.h>

#include <array>
#include <cmath>
#include <cstring>
#include <vector>

#include "target.hpp"

namespace {

/// Takes numbers off an input and returns zeros where it has ended.
class Bytes {
 public:
  Bytes(const std::uint8_t* data, std::size_t size) : data_(data), end_(data + size) {}

  bool empty() const { return data_ == end_; }
  std::uint8_t byte() { return empty() ? std::uint8_t{0} : *data_++; }
  std::int32_t below(int bound) { return byte() % bound; }
  /// Returns mostly a number that a host has, at times one that it should not have.
  double number() {
    constexpr std::array<double, 12> odd{0.0, -0.0, 1.0, -1.0, 1e308, -1e308, 5e-324, 1e-12, 1e9, INFINITY, NAN, 0.5};
    const std::uint8_t first = byte();
    return first < odd.size() ? odd[first] : (first - 128) / 64.0 + byte() / 16384.0;
  }
  /// Returns the number of one of n points, at times of none.
  std::int32_t point(std::size_t n) { return below(static_cast<int>(n) + 3) - 1; }

 private:
  const std::uint8_t* data_;
  const std::uint8_t* end_;
};

[[noreturn]] void complain(const char* what) {
  std::fprintf(stderr, "%s\n", what);
  std::abort();
}

/// A host with its arrays.
class Host {
 public:
  explicit Host(Bytes* bytes) : bytes_(*bytes), n_(static_cast<std::size_t>(bytes_.below(most_points + 1))) {
    masses_.resize(most_points);
    for (double& mass : masses_) mass = bytes_.below(8) == 0 ? INFINITY : 1.0 + bytes_.below(4);
    for (std::vector<double>* array : {&x_old_, &x_, &v_, &f_, &w_}) array->resize(stride * most_points);
    for (std::size_t k = 0; k < x_.size(); ++k)
      x_[k] = x_old_[k] = static_cast<double>((7 * k) % 11) + bytes_.number() / 8.0;
    for (double& v : v_) v = bytes_.below(16) / 16.0;
    options_ = {sizeof(tn_options), 1, bytes_.below(4) == 0 ? bytes_.number() : 0.0, bytes_.below(2)};
    tn_create(&system_, n_, masses_.data(), const_points(x_), &options_);
  }
  ~Host() { tn_destroy(system_); }
  Host(const Host&) = delete;
  Host& operator=(const Host&) = delete;

  void call() {
    using Call = void (Host::*)();
    constexpr Call calls[] = {&Host::add_rods,     &Host::add_rods,    &Host::add,      &Host::remove,
                              &Host::set_lengths,  &Host::set_masses,  &Host::renumber, &Host::set_box,
                              &Host::expect_edits, &Host::plan,        &Host::ask,      &Host::solve,
                              &Host::step,         &Host::step,        &Host::project,  &Host::run_loop,
                              &Host::save_restore, &Host::other_state, &Host::move,     &Host::measure};
    (this->*calls[bytes_.below(std::size(calls))])();
  }

 private:
  using Arrays = std::vector<std::vector<double>>;
  static constexpr std::size_t most_points = 6, most_members = 4, stride = 3;

  tn_points points(std::vector<double>& array) { return {array.data(), 0, nullptr}; }
  tn_const_points const_points(const std::vector<double>& array) const { return {array.data(), 0, nullptr}; }

  /// Ends the program if a failed call has changed an array, or if a success has written NaN.
  void check(int code, std::vector<std::vector<double>*> arrays, const Arrays& before) {
    for (std::size_t k = 0; k < arrays.size(); ++k) {
      if (code != TN_OK && std::memcmp(arrays[k]->data(), before[k].data(), sizeof(double) * before[k].size()) != 0)
        complain("a call that failed has changed an array");
      for (std::size_t i = 0; code == TN_OK && i < 3 * n_; ++i)
        if (!std::isfinite((*arrays[k])[i]) && std::isfinite(before[k][i])) complain("a call that is good gave a NaN");
    }
    if (code == TN_EINTERNAL) complain(tn_last_error(system_));
    if (code != TN_OK && tn_last_error(system_)[0] == '\0') complain("a call failed without a word");
  }

  void take_ids(int code, std::size_t count) {
    if (code == TN_OK) ids_.insert(ids_.end(), new_ids_.begin(), new_ids_.begin() + static_cast<std::ptrdiff_t>(count));
  }
  std::vector<std::int64_t> some_ids() {
    std::vector<std::int64_t> some(static_cast<std::size_t>(bytes_.below(most_members)));
    for (std::int64_t& id : some)
      id = ids_.empty() || bytes_.below(16) == 0 ? bytes_.byte() - 1 : ids_[bytes_.byte() % ids_.size()];
    return some;
  }

  void add_rods() {
    const auto count = static_cast<std::size_t>(bytes_.below(most_members + 1));
    std::array<std::int32_t, 2 * most_members> pairs;
    for (std::int32_t& i : pairs) i = bytes_.point(n_);
    std::array<double, most_members> lengths;
    for (double& length : lengths) length = bytes_.number();
    std::array<std::int32_t, 3 * most_members> images;
    for (std::int32_t& image : images) image = bytes_.below(3) - 1;
    const int how = bytes_.below(8);
    const int code = tn_add_rods(system_, count, pairs.data(), how == 1 ? lengths.data() : nullptr,
                                 how == 2 ? images.data() : nullptr, new_ids_.data());
    check(code, {}, {});
    take_ids(code, count);
  }
  void add() {
    const auto kind = static_cast<tn_kind>(bytes_.below(8));
    const auto count = static_cast<std::size_t>(bytes_.below(most_members + 1));
    std::array<std::int32_t, 3 * most_members> points;
    for (std::int32_t& i : points) i = bytes_.point(n_);
    std::array<double, 7 * most_members> parameters;
    for (double& parameter : parameters) parameter = bytes_.number();
    const int code = tn_add(system_, kind, count, points.data(), bytes_.below(3) == 0 ? nullptr : parameters.data(),
                            new_ids_.data());
    check(code, {}, {});
    take_ids(code, count);
  }
  void remove() {
    const std::vector<std::int64_t> ids = some_ids();
    check(tn_remove(system_, ids.size(), ids.data()), {}, {});
  }
  void set_lengths() {
    const std::vector<std::int64_t> ids = some_ids();
    std::array<double, most_members> lengths, rates;
    for (double& length : lengths) length = bytes_.number();
    for (double& rate : rates) rate = bytes_.number();
    check(tn_set_lengths(system_, ids.size(), ids.data(), lengths.data(), bytes_.below(2) ? rates.data() : nullptr), {},
          {});
  }
  void set_masses() {
    const std::array<std::int32_t, 2> points{bytes_.point(n_), bytes_.point(n_)};
    const std::array<double, 2> masses{bytes_.number(), bytes_.number()};
    check(tn_set_masses(system_, static_cast<std::size_t>(bytes_.below(3)), points.data(), masses.data()), {}, {});
  }
  void renumber() {
    const auto next = static_cast<std::size_t>(bytes_.below(most_points + 1));
    std::array<std::int64_t, most_points> from;
    for (std::int64_t& i : from) i = bytes_.point(n_);
    const int code = tn_renumber(system_, next, from.data(), masses_.data(), const_points(x_));
    check(code, {}, {});
    if (system_ != nullptr) n_ = tn_num_points(system_);
    if (n_ > most_points) complain("there are more points than ever were");
  }
  void set_box() {
    std::array<double, 9> cell{10, 0, 0, 0, 10, 0, 0, 0, 10};
    for (double& edge : cell)
      if (bytes_.below(4) == 0) edge = bytes_.number();
    const std::array<int, 3> repeats{bytes_.below(2), bytes_.below(2), bytes_.below(2)};
    const bool is_old = bytes_.below(4) == 0;
    check(is_old ? tn_set_old_box(system_, cell.data()) : tn_set_box(system_, cell.data(), repeats.data()), {}, {});
  }
  void expect_edits() { check(tn_expect_edits(system_), {}, {}); }
  void plan() {
    std::size_t islands = 0;
    check(tn_plan(system_, &islands), {}, {});
  }
  void ask() {
    std::size_t first = 0, count = 0;
    check(tn_rows(system_, bytes_.byte() - 1, &first, &count), {}, {});
    std::array<char, 16> name;
    const std::size_t row = bytes_.byte();
    check(tn_row_name(system_, row, name.data(), static_cast<std::size_t>(bytes_.below(17))), {}, {});
    constexpr const char* texts[] = {"tension(rod0)",      "max tension(rod1)",   "load(support0)",
                                     "moment(rod0, z, 0)", "temperature()",       "force(plane1)",
                                     "tension(rod0[1])",   "position(all)",       "energy()",
                                     "angle(0, 1, ",       "each load(support0)", "2*distance(0, 3) + t"};
    check(tn_add_observable(system_, texts[row % std::size(texts)], nullptr), {}, {});
  }

  /// Makes room for the optional results of a call.
  tn_wanted want() {
    multipliers_.assign(tn_num_rows(system_), 0.0);
    forces_.assign(stride * most_points, 0.0);
    stress_.assign(9 * most_points, 0.0);
    tn_wanted wanted{sizeof(tn_wanted), bytes_.below(2), nullptr, {}, {}};
    if (bytes_.below(2)) wanted.multipliers = multipliers_.data();
    if (bytes_.below(2)) wanted.forces = points(forces_);
    if (bytes_.below(2)) wanted.stress = points(stress_);
    return wanted;
  }
  tn_report report() {
    tn_report report{};
    report.size =
        static_cast<std::uint32_t>(bytes_.below(4) == 0 ? bytes_.byte() % sizeof(tn_report) : sizeof(tn_report));
    return report;
  }
  double step_size() { return bytes_.below(8) == 0 ? bytes_.number() : 1e-3; }

  void step() {
    const double dt = step_size();
    const tn_wanted wanted = want();
    tn_report found = report();
    if (bytes_.below(2)) {
      const Arrays before{x_, v_};
      check(tn_constrain_positions(system_, dt, const_points(x_old_), points(x_), points(v_), &wanted, &found),
            {&x_, &v_}, before);
    } else {
      const Arrays before{v_};
      check(tn_constrain_velocities(system_, dt, const_points(x_), points(v_), &wanted, &found), {&v_}, before);
    }
    x_old_ = x_;
  }
  void solve() {
    const tn_wanted wanted = want();
    tn_report found = report();
    const Arrays before{w_};
    check(tn_solve(system_, const_points(x_), const_points(v_), const_points(f_), points(w_), &wanted, &found), {&w_},
          before);
    observe(wanted);
  }
  /// Reads no bytes, so that inputs that were found before mean what they did.
  void observe(const tn_wanted& wanted) {
    const Arrays before{w_};
    const tn_const_points f = wanted.measures != 0 ? const_points(f_) : tn_const_points{};
    const int code = tn_observe(system_, v_[0], const_points(x_), const_points(v_), f, points(w_), &wanted, nullptr);
    check(code, {&w_}, before);
    for (std::size_t k = 0, size = 0; tn_observed(system_, k, nullptr, &size) == TN_OK; ++k) {
      std::vector<double> values(size);
      check(tn_observed(system_, k, values.data(), &size), {}, {});
      std::array<char, 16> name;
      check(tn_column_name(system_, k, size - 1, name.data(), name.size()), {}, {});
      check(tn_observed_member(system_, k, name.data(), name.size()), {}, {});
      for (const tn_which which : {TN_LEAST, TN_LARGEST})
        check(tn_extreme(system_, k, size % 4, which, nullptr, nullptr, name.data(), name.size()), {}, {});
    }
    if (code == TN_EINVAL) check(tn_remove_observable(system_, 0), {}, {});
  }
  void project() {
    const tn_wanted wanted = want();
    tn_report found = report();
    const Arrays before{x_, f_};
    const bool positions = bytes_.below(2) == 0;
    check(positions ? tn_project_positions(system_, points(x_), &found)
                    : tn_project_forces(system_, const_points(x_), points(f_), &wanted, &found),
          {&x_, &f_}, before);
  }
  void run_loop() {
    tn_loop loop{};
    loop.size = sizeof(tn_loop);
    loop.measures = bytes_.below(2);
    loop.dt = step_size();
    loop.steps = static_cast<std::size_t>(bytes_.below(4));
    loop.x = points(x_);
    loop.v = points(v_);
    loop.f = points(f_);
    loop.user = this;
    loop.observe = [](void* user, const tn_progress*) {
      Host& host = *static_cast<Host*>(user);
      if (host.bytes_.below(4) == 0) host.add_rods();
      return host.bytes_.below(8) != 0 ? 1 : 0;
    };
    std::size_t steps = 0;
    check(tn_run(system_, &loop, &steps), {}, {});
    x_old_ = x_;
  }
  void save_restore() {
    std::size_t size = 0;
    check(tn_save(system_, nullptr, &size), {}, {});
    std::vector<std::uint8_t> state(size);
    if (tn_save(system_, state.data(), &size) != TN_OK) return;
    if (bytes_.below(2) && !state.empty()) state[bytes_.byte() * state.size() / 256] ^= bytes_.byte();
    check(tn_restore(system_, state.data(), state.size() - bytes_.byte() % (state.size() + 1) / 2), {}, {});
  }
  /// Restores bytes that nobody saved.
  void other_state() {
    std::array<std::uint8_t, 64> state;
    for (std::uint8_t& byte : state) byte = bytes_.byte();
    check(tn_restore(system_, state.data(), state.size()), {}, {});
  }
  void move() {
    std::vector<double>* const arrays[] = {&x_, &v_, &f_, &x_old_};
    (*arrays[bytes_.below(4)])[bytes_.byte() % (stride * most_points)] = bytes_.number();
  }
  void measure() {
    double value = 0.0;
    const Arrays before{w_};
    check(tn_log_det(system_, const_points(x_), &value, bytes_.below(2) ? points(w_) : tn_points{}), {&w_}, before);
    std::array<std::uint8_t, most_points> group;
    for (std::uint8_t& member : group) member = static_cast<std::uint8_t>(bytes_.below(2));
    check(tn_removed_dof(system_, const_points(x_), group.data(), &value), {}, {});
    tn_report found = report();
    check(tn_violation(system_, const_points(x_), &found), {}, {});
  }

  Bytes& bytes_;
  std::size_t n_;
  tn_options options_{};
  tn_system* system_ = nullptr;
  std::vector<double> masses_, x_old_, x_, v_, f_, w_, multipliers_, forces_, stress_;
  std::vector<std::int64_t> ids_;
  std::array<std::int64_t, most_members> new_ids_{};
};

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  constexpr int most_calls = 48;
  Bytes bytes(data, size);
  Host host(&bytes);
  for (int k = 0; k < most_calls && !bytes.empty(); ++k) host.call();
  return 0;
}
