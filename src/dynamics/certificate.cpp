#include "dynamics/certificate.hpp"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <numeric>
#include <random>
#include <span>

#include "evaluate/definitions.hpp"
#include "factor/sparse_qr.hpp"
#include "system/members.hpp"
#include "system/text.hpp"

namespace tanor {

bool Certificate::passed() const {
  return std::ranges::all_of(checks, [](const CertificateCheck& check) { return check.error <= check.allowed; });
}

double Certificate::certified_to() const {
  double worst = 0.0;
  for (const double error : {residual, forms_agree, second_factorization, power_balance, orthogonality}) {
    if (!std::isnan(error)) worst = std::max(worst, error);
  }
  return worst;
}

std::string Certificate::line() const {
  const auto digits = [](double x) {
    std::array<char, 16> buffer;
    const auto end =
        std::to_chars(buffer.data(), buffer.data() + buffer.size(), x, std::chars_format::scientific, 1).ptr;
    return std::string(buffer.data(), end);
  };
  for (const CertificateCheck& check : checks) {
    if (check.error <= check.allowed) continue;
    return "not certified: " + check.identity + " fails by " + digits(check.error) +
           (check.where.empty() ? "" : " at " + check.where) + " (rounding explains " + digits(check.allowed) + ")";
  }
  if (checks.empty()) return "nothing to certify: no point moves";
  return "certified to " + digits(certified_to());
}

namespace {

constexpr double eps = std::numeric_limits<double>::epsilon();
using Vector = std::vector<double>;

/// The largest of some relative errors, and where it was.
struct Worst {
  double error = 0.0;
  std::size_t index = 0;

  void see(double value, std::size_t i) {
    if (!(value <= error)) {
      error = value;
      index = i;
    }
  }
};

class Judge {
 public:
  Judge(Forms& forms, const Answer& answer)
      : forms_(forms),
        model_(forms.model),
        answer_(answer),
        n_(3 * model_.num_points()),
        moving_(3 * model_.num_moving()),
        d_(model_.num_rows()) {
    model_.set_time(answer.t);
    measure_scale();
  }

  Certificate judge() {
    if (model_.num_moving() == 0) return std::move(result_);
    if (d_ == 0 && forms_.tangent == nullptr) judge_free();
    has_both_ = d_ > 0 && forms_.tangent != nullptr && forms_.normal != nullptr;
    if (has_both_) solve_other();
    if (d_ > 0 && forms_.normal != nullptr) rcond_of_S_ = forms_.normal->estimate_reciprocal_condition();
    if (forms_.tangent != nullptr) rcond_of_H_ = forms_.tangent->estimate_reciprocal_condition();
    result_.reciprocal_condition = std::min(rcond_of_S_, rcond_of_H_);
    if (d_ > 0) judge_constraints();
    if (forms_.tangent != nullptr) judge_coordinates();
    if (has_both_) judge_both();
    return std::move(result_);
  }

 private:
  // ---- words ----

  /// Accelerations are measured by the largest of w, M^-1 f and M^-1 eta.
  void measure_scale() {
    w0_.assign(n_, 0.0);
    acceleration_ = model_.evaluate_free(answer_.t, answer_.r.data(), answer_.v.data(), w0_.data());
    acceleration_ = std::max(acceleration_, model_.largest_norm(answer_.w.data()));
    for (std::size_t i = 0; i < model_.num_moving(); ++i) {
      acceleration_ = std::max(acceleration_, model_.inverse_mass[i] * norm(load(answer_.eta.data(), i)));
    }
    if (!(acceleration_ > 0.0)) acceleration_ = 1.0;
  }

  void add(double* figure, const std::string& identity, double error, double allowed, const std::string& where) {
    if (std::isnan(*figure) || !(error <= *figure)) *figure = error;
    result_.checks.push_back({identity, error, allowed, where});
  }
  void add_row(double* figure, const std::string& identity, const Worst& worst, double allowed) {
    const std::string where = worst.error > 0.0 ? equation_name(model_.system, worst.index) : "";
    add(figure, identity, worst.error, allowed, where);
  }
  void add_point(double* figure, const std::string& identity, const Worst& worst, double allowed) {
    const std::string where =
        worst.error > 0.0 ? "point " + text(model_.numbering.user_point[worst.index]) : std::string();
    add(figure, identity, worst.error, allowed, where);
  }
  Worst worst_point(const Vector& difference, double scale) const {
    Worst worst;
    for (std::size_t i = 0; i < model_.num_moving(); ++i) worst.see(norm(load(difference.data(), i)) / scale, i);
    return worst;
  }

  Vector to_user(const Vector& inner) const {
    Vector user(n_);
    model_.numbering.scatter_points(inner, user);
    return user;
  }
  /// Independent of everything but the seed: no identity may hold by chance.
  Vector random_points() {
    Vector u(n_, 0.0);
    std::normal_distribution<double> normal;
    for (std::size_t i = 0; i < moving_; ++i) u[i] = normal(generator_);
    return u;
  }
  /// sum of m x y over the moving points
  double product(const Vector& x, const Vector& y) const {
    return model_.parallel.sum(
        model_.num_moving(), [&](std::size_t i) { return model_.mass[i] * dot(load(x.data(), i), load(y.data(), i)); });
  }
  double norm_of(const Vector& x) const { return std::sqrt(product(x, x)); }

  /// Neither constraints nor coordinates: M w = f.
  void judge_free() {
    Vector rest(n_, 0.0);
    for (std::size_t i = 0; i < moving_; ++i) rest[i] = answer_.w[i] - w0_[i];
    add_point(&result_.residual, "M w = f", worst_point(rest, acceleration_), 1e-14);
  }

  // ---- constraints ----

  void judge_constraints() {
    const Vector &r = answer_.r, &v = answer_.v;
    Definitions definitions(model_.system, forms_.start_time());
    user_r_ = to_user(r);
    Vector xi(d_), rate(d_), second(d_);
    row_norms_ = measure_rows();
    const double curvature = measure_curvature(definitions);
    const double scale = std::max(acceleration_, curvature);
    const double rounding = rounding_of_places();

    // K'w + phi: the second derivative of xi along r + e v + e^2/2 w
    definitions.taylor(model_.parallel, answer_.t, user_r_, to_user(v), to_user(answer_.w), xi, rate, second);
    Worst worst;
    for (std::size_t a = 0; a < d_; ++a) worst.see(std::abs(second[a]) / (row_norms_[a] * scale), a);
    add_row(&result_.residual, "K'w + phi = 0", worst, 1e-10 + rounding);

    // M w = f + K lambda
    Vector lambda(d_), K_lambda(n_), inner(n_);
    model_.numbering.scatter_rows(answer_.lambda, lambda);
    turn_pairs_of_lines(definitions, &lambda);
    definitions.reactions(answer_.t, user_r_, lambda, K_lambda);
    model_.numbering.gather_points(K_lambda, inner);
    Vector rest(n_, 0.0);
    for (std::size_t i = 0; i < moving_; ++i) {
      rest[i] = answer_.w[i] - w0_[i] - model_.inverse_mass[i / 3] * inner[i];
    }
    add_point(&result_.residual, "M w = f + K lambda", worst_point(rest, scale), 1e-10 + rounding);

    judge_power(definitions, lambda, K_lambda);
    if (forms_.tangent == nullptr) {
      judge_normal_projector(definitions);
      judge_by_qr(scale);
    }
    judge_split();
  }

  /// The two unit vectors of a line that turns are a convention, which the definitions may keep otherwise: what the
  /// pair carries, K lambda at its point, is taken apart along theirs.
  void turn_pairs_of_lines(const Definitions& definitions, Vector* lambda) const {
    std::vector<char> turns(d_, 0);
    std::size_t row = 0;
    for (const Constraint& constraint : model_.system.constraints) {
      const auto* const lines = std::get_if<Lines>(&constraint);
      const bool moves = lines != nullptr && !lines->direction.is_constant();
      const std::size_t rows = std::visit(
          []<class Group>(const Group& group) { return num_members(group) * rows_per_member<Group>(); }, constraint);
      std::fill_n(turns.begin() + static_cast<std::ptrdiff_t>(row), rows, moves);
      row += rows;
    }
    if (std::ranges::none_of(turns, [](char turn) { return turn != 0; })) return;
    Vector blocks(3 * model_.constraints.num_blocks()), carried(n_, 0.0), along(d_);
    model_.constraints.evaluate_gradients(model_.parallel, answer_.r.data(), blocks.data());
    for (const Incidence& i : model_.incidences) {
      const auto user_row = static_cast<std::size_t>(model_.numbering.user_row[static_cast<std::size_t>(i.row)]);
      if (turns[user_row] == 0) continue;
      const double factor = i.sign * answer_.lambda[static_cast<std::size_t>(i.row)];
      store(carried.data(), i.point, load(carried.data(), i.point) + factor * load(blocks.data(), i.block));
    }
    definitions.transposed(answer_.t, user_r_, to_user(carried), along);
    for (std::size_t a = 0; a < d_; ++a) {
      if (turns[a] != 0) (*lambda)[a] = along[a];
    }
  }

  /// |column of K| of each of the user's rows.
  Vector measure_rows() const {
    Vector blocks(3 * model_.constraints.num_blocks()), inner(d_, 0.0), result(d_);
    model_.constraints.evaluate_gradients(model_.parallel, answer_.r.data(), blocks.data());
    for (const Incidence& incidence : model_.incidences) {
      const Vec3 g = load(blocks.data(), incidence.block);
      inner[static_cast<std::size_t>(incidence.row)] += dot(g, g);
    }
    model_.numbering.scatter_rows(inner, result);
    for (double& x : result) x = x > 0.0 ? std::sqrt(x) : 1.0;
    return result;
  }

  /// max |phi|/|gradient|: phi along r + e v, with what is prescribed at supports.
  double measure_curvature(const Definitions& definitions) {
    Vector given(n_, 0.0), xi(d_), rate(d_);
    std::copy(model_.support_accelerations.begin(), model_.support_accelerations.end(), given.data() + moving_);
    phi_.resize(d_);
    definitions.taylor(model_.parallel, answer_.t, user_r_, to_user(answer_.v), to_user(given), xi, rate, phi_);
    double worst = 0.0;
    for (std::size_t a = 0; a < d_; ++a) worst = std::max(worst, std::abs(phi_[a]) / row_norms_[a]);
    return worst;
  }

  /// Directions are differences of places: what their rounding does, eps |r|/L.
  double rounding_of_places() const {
    return 1e2 * eps * std::max(1.0, model_.largest_norm(answer_.r.data()) / model_.smallest_length);
  }

  /// eta'v + lambda'xi_t = 0 over all points, supports too.
  void judge_power(const Definitions& definitions, const Vector& lambda, const Vector& eta) {
    const Vector user_v = to_user(answer_.v), zero(n_, 0.0);
    Vector xi(d_), second(d_);
    xi_t_.assign(d_, 0.0);
    if (model_.constraints.depends_on_time()) {
      definitions.taylor(model_.parallel, answer_.t, user_r_, zero, zero, xi, xi_t_, second);
    }
    double sum = 0.0, size = 0.0;
    for (std::size_t i = 0; i < n_ / 3; ++i) {
      sum += dot(load(eta.data(), i), load(user_v.data(), i));
      size += norm(load(eta.data(), i)) * std::max(norm(load(user_v.data(), i)), model_.velocity_scale * 1e-3);
    }
    for (std::size_t a = 0; a < d_; ++a) {
      sum += lambda[a] * xi_t_[a];
      size += std::abs(lambda[a] * xi_t_[a]);
    }
    // Velocities satisfy K'v + xi_t = 0 to the tolerance of their projection.
    add(&result_.power_balance, "eta'v = -lambda'xi_t", size > 0.0 ? std::abs(sum) / size : 0.0, 1e-9, "");
  }

  /// u -> S^-1 K'u as rows (inner), K as the normal form has it.
  Vector multipliers_of(const Vector& u) {
    Vector x(d_);
    model_.constraints.apply_transposed(model_.parallel, forms_.normal->blocks().data(), u.data(), nullptr, x.data());
    forms_.normal->solve_negative(x.data());
    for (double& value : x) value = -value;
    return x;
  }
  /// Q u = u - M^-1 K S^-1 K'u
  Vector project_onto_tangent(const Vector& u) {
    Vector x = multipliers_of(u), result = u;
    for (double& value : x) value = -value;
    model_.gather.add_scaled(model_.parallel, forms_.normal->blocks().data(), x.data(), model_.inverse_mass.data(),
                             model_.num_moving(), result.data());
    return result;
  }

  /// What solves with a matrix of this reciprocal condition may lose.
  static double conditioned(double reciprocal_condition) { return std::max(1e-11, 1e3 * eps / reciprocal_condition); }

  void judge_normal_projector(const Definitions& definitions) {
    const double rcond = rcond_of_S_;
    const double allowed = conditioned(rcond) + rounding_of_places();
    const Vector u = random_points(), y = random_points();
    const Vector Qu = project_onto_tangent(u), QQu = project_onto_tangent(Qu), Qy = project_onto_tangent(y);
    const double size = model_.largest_norm(u.data());

    // K'Q u is the rate of xi along Q u, without xi_t
    const Vector zero(n_, 0.0);
    Vector xi(d_), rate(d_), second(d_);
    definitions.taylor(model_.parallel, answer_.t, user_r_, to_user(Qu), zero, xi, rate, second);
    Worst worst;
    for (std::size_t a = 0; a < d_; ++a) worst.see(std::abs(rate[a] - xi_t_[a]) / (row_norms_[a] * size), a);
    add_row(&result_.normal_identity, "K'Q u = 0", worst, allowed);

    Vector rest(n_);
    for (std::size_t i = 0; i < n_; ++i) rest[i] = QQu[i] - Qu[i];
    add_point(&result_.normal_identity, "Q Q u = Q u", worst_point(rest, size), allowed);

    const double asymmetry = std::abs(product(y, Qu) - product(u, Qy)) / (norm_of(u) * norm_of(y));
    add(&result_.normal_identity, "y'M Q u = u'M Q y", asymmetry, allowed, "");
  }

  /// w once more from scratch: C = M^-1/2 K with unit columns, R of its QR, C'C lambda = -(phi + K'w0) by seminormal
  /// equations, refined in w.
  void judge_by_qr(double scale) {
    constexpr std::size_t most_rows = 200000;  // the memory of R
    if (d_ > most_rows) return;
    Vector blocks(3 * model_.constraints.num_blocks());
    model_.constraints.evaluate_gradients(model_.parallel, answer_.r.data(), blocks.data());
    Vector lengths;
    const SparseColumns C = scaled_columns(blocks, &lengths);
    const ColumnOrder order = forms_.normal->is_without_fill() ? ColumnOrder::Given : ColumnOrder::FillReducing;
    const TriangularFactor R = factorize_qr(C, 20.0 * static_cast<double>(d_ + n_) * eps, order);

    Vector w(n_, 0.0), phi(d_), rows(d_), packed(R.rank());
    std::copy_n(w0_.begin(), moving_, w.begin());
    for (std::size_t a = 0; a < d_; ++a) phi[a] = phi_[static_cast<std::size_t>(model_.numbering.user_row[a])];
    constexpr int passes = 2;
    for (int pass = 0; pass < passes; ++pass) {
      // rho = K'w + phi, with what is prescribed at supports in phi; w -= M^-1 K (R'R)^-1 rho
      model_.constraints.apply_transposed(model_.parallel, blocks.data(), w.data(), phi.data(), rows.data());
      for (std::size_t k = 0; k < R.rank(); ++k) {
        const auto row = static_cast<std::size_t>(R.independent[k]);
        packed[k] = -rows[row] / lengths[row];
      }
      R.solve_transposed(packed.data());
      R.solve(packed.data());
      std::fill(rows.begin(), rows.end(), 0.0);
      for (std::size_t k = 0; k < R.rank(); ++k) {
        const auto row = static_cast<std::size_t>(R.independent[k]);
        rows[row] = packed[k] / lengths[row];
      }
      model_.gather.add_scaled(model_.parallel, blocks.data(), rows.data(), model_.inverse_mass.data(),
                               model_.num_moving(), w.data());
    }
    for (std::size_t i = 0; i < moving_; ++i) w[i] -= answer_.w[i];
    // Both stand on the same rounded places; each is refined in w.
    const double rcond = rcond_of_S_;
    add_point(&result_.second_factorization, "w of QR = w of Cholesky", worst_point(w, scale),
              std::max(1e-9, 10.0 * eps / rcond) + rounding_of_places());
  }

  /// Columns of M^-1/2 K of the rows that take part, to unit length; `lengths` [inner row].
  SparseColumns scaled_columns(const Vector& blocks, Vector* lengths) const {
    // Incidences by row, then by the order of its points.
    struct Entry {
      Index point;
      Vec3 value;
    };
    std::vector<std::size_t> first(d_ + 1, 0);
    const auto weight_of = [&](const Incidence& i) { return model_.inverse_mass[static_cast<std::size_t>(i.point)]; };
    for (const Incidence& i : model_.incidences) first[static_cast<std::size_t>(i.row) + 1] += weight_of(i) > 0.0;
    std::partial_sum(first.begin(), first.end(), first.begin());
    std::vector<Entry> entries(first.back());
    std::vector<std::size_t> next(first.begin(), first.end() - 1);
    for (const Incidence& i : model_.incidences) {
      if (weight_of(i) == 0.0) continue;
      const Vec3 value = (i.sign * std::sqrt(weight_of(i))) * load(blocks.data(), i.block);
      entries[next[static_cast<std::size_t>(i.row)]++] = {i.point, value};
    }
    SparseColumns C;
    C.num_rows = static_cast<int>(moving_);
    C.rows.reserve(3 * entries.size());
    C.values.reserve(3 * entries.size());
    lengths->assign(d_, 1.0);
    for (std::size_t row = 0; row < d_; ++row) {
      const auto own = std::span(entries).subspan(first[row], first[row + 1] - first[row]);
      std::ranges::sort(own, {}, &Entry::point);
      double square = 0.0;
      for (const Entry& e : own) square += dot(e.value, e.value);
      if (square > 0.0) (*lengths)[row] = std::sqrt(square);
      for (const auto& [point, vector] : own) {
        const Vec3 value = (1.0 / (*lengths)[row]) * vector;
        for (int c = 0; c < 3; ++c) C.rows.push_back(3 * point + c);
        C.values.insert(C.values.end(), {value.x, value.y, value.z});
      }
      C.start.push_back(static_cast<int>(C.rows.size()));
    }
    return C;
  }

  /// With equal masses w_T lies in T and w_N in N: w_T'M w_N = 0, w_N = -K Gamma^-1 phi, Gamma = m S (36).
  void judge_split() {
    const auto moving_masses = std::span(model_.mass).first(model_.num_moving());
    const bool is_one_mass = std::ranges::all_of(moving_masses, [&](double m) { return m == moving_masses[0]; });
    if (!is_one_mass || forms_.normal == nullptr) return;
    // S x = -phi; w_N = M^-1 K x, since K Gamma^-1 = K (m S)^-1
    Vector x(d_), w_N(n_, 0.0), w_T(n_, 0.0);
    for (std::size_t a = 0; a < d_; ++a) x[a] = phi_[static_cast<std::size_t>(model_.numbering.user_row[a])];
    forms_.normal->solve_negative(x.data());
    model_.gather.add_scaled(model_.parallel, forms_.normal->blocks().data(), x.data(), model_.inverse_mass.data(),
                             model_.num_moving(), w_N.data());
    for (std::size_t i = 0; i < moving_; ++i) w_T[i] = answer_.w[i] - w_N[i];
    // Where nothing pushes w_T is rounding of w_N: both are measured by the larger of w and M^-1 f.
    const double size = std::max(product(answer_.w, answer_.w), product(w0_, w0_));
    const double rcond = rcond_of_S_;
    add(&result_.orthogonality, "w_T'M w_N = 0", size > 0.0 ? std::abs(product(w_T, w_N)) / size : 0.0,
        conditioned(rcond), "");
  }

  // ---- coordinates ----

  /// A H^-1 A'M u
  Vector project_by_coordinates(const Vector& u) {
    Vector Mu(n_, 0.0), x(model_.coordinates.num_coordinates()), result(n_, 0.0);
    for (std::size_t i = 0; i < moving_; ++i) Mu[i] = model_.mass[i / 3] * u[i];
    const Vector& blocks = forms_.tangent->blocks();
    model_.coordinates.apply_transposed(model_.parallel, blocks.data(), Mu.data(), x.data());
    forms_.tangent->solve_negative(x.data());
    for (double& value : x) value = -value;
    model_.coordinates.apply(model_.parallel, blocks.data(), x.data(), result.data());
    std::fill(result.begin() + static_cast<std::ptrdiff_t>(moving_), result.end(), 0.0);
    return result;
  }

  void judge_coordinates() {
    const double rcond = rcond_of_H_;
    const double allowed = conditioned(rcond);

    // A'(M w - f) = 0, seen as an acceleration: A H^-1 A'(M w - f)
    Vector rest(n_, 0.0);
    for (std::size_t i = 0; i < moving_; ++i) rest[i] = answer_.w[i] - w0_[i];
    add_point(&result_.residual, "A'(M w - f) = 0", worst_point(project_by_coordinates(rest), acceleration_),
              1e-11 + 1e2 * eps / rcond);

    if (forms_.is_tangent()) judge_curve();
    if (d_ > 0) return;
    const Vector u = random_points(), y = random_points();
    const Vector Pu = project_by_coordinates(u), PPu = project_by_coordinates(Pu), Py = project_by_coordinates(y);
    for (std::size_t i = 0; i < n_; ++i) rest[i] = PPu[i] - Pu[i];
    add_point(&result_.tangent_identity, "P P u = P u, P = A H^-1 A'M",
              worst_point(rest, model_.largest_norm(u.data())), allowed);
    const double asymmetry = std::abs(product(y, Pu) - product(u, Py)) / (norm_of(u) * norm_of(y));
    add(&result_.tangent_identity, "y'M P u = u'M P y", asymmetry, allowed, "");
  }

  /// w = d2 r(q(t), t)/dt2 by differences of places alone, which share no derivative with A and psi: a stencil of
  /// order 8.
  void judge_curve() {
    const double speed = std::max(model_.largest_norm(answer_.v.data()), 1e-3 * model_.velocity_scale);
    const double h = 0.02 * std::min(speed / acceleration_, model_.scene_size / speed);
    constexpr double weights[] = {-205.0 / 72.0, 8.0 / 5.0, -1.0 / 5.0, 8.0 / 315.0, -1.0 / 560.0};
    Vector sum(n_, 0.0), place(n_);
    try {
      for (int k = -4; k <= 4; ++k) {
        forms_.tangent->write_place_along(k * h, place.data());
        for (std::size_t i = 0; i < moving_; ++i) sum[i] += weights[std::abs(k)] * (place[i] - answer_.r[i]);
      }
    } catch (const InputError&) {
      model_.set_time(answer_.t);  // a table ends here: no curve to try
      return;
    }
    model_.set_time(answer_.t);
    for (std::size_t i = 0; i < moving_; ++i) sum[i] = sum[i] / (h * h) - answer_.w[i];
    const double far = eps * model_.largest_norm(answer_.r.data()) / (h * h * acceleration_);
    Certificate apart;  // an eye with fewer digits: it judges, but does not enter the digits certified
    add_point(&apart.residual, "w = d2/dt2 r(q(t), t)", worst_point(sum, acceleration_), 1e-6 + 1e2 * far);
  }

  // ---- both ----

  void judge_both() {
    const double rcond =
        std::min(forms_.tangent->last_solve().reciprocal_condition, forms_.normal->last_solve().reciprocal_condition);
    const double allowed = conditioned(rcond) + rounding_of_places();
    // (9): A H^-1 A'M u + M^-1 K S^-1 K'u = u;  (10) is M (9) M^-1
    const Vector u = random_points();
    const double size = model_.largest_norm(u.data());
    Vector rest = project_by_coordinates(u);
    const Vector Qu = project_onto_tangent(u);
    for (std::size_t i = 0; i < moving_; ++i) rest[i] -= Qu[i];
    add_point(&result_.normal_identity, "A H^-1 A'M + M^-1 K S^-1 K' = I (9)", worst_point(rest, size), allowed);

    // K'A x = 0 (3)
    Vector x(model_.coordinates.num_coordinates()), Ax(n_, 0.0), rows(d_);
    std::normal_distribution<double> normal;
    for (double& value : x) value = normal(generator_);
    model_.coordinates.apply(model_.parallel, forms_.tangent->blocks().data(), x.data(), Ax.data());
    model_.constraints.apply_transposed(model_.parallel, forms_.normal->blocks().data(), Ax.data(), nullptr,
                                        rows.data());
    Worst worst;
    const double size_of_Ax = model_.largest_norm(Ax.data());
    for (std::size_t a = 0; a < d_; ++a) {
      const auto row = static_cast<std::size_t>(model_.numbering.user_row[a]);
      worst.see(std::abs(rows[a]) / (row_norms_[row] * size_of_Ax), row);
    }
    add_row(&result_.bases_orthogonal, "K'A = 0 (3)", worst, 1e-11 + rounding_of_places());

    judge_euclidean();
    compare_forms();
  }

  /// (15): A G^-1 A'u + K Gamma^-1 K'u = u
  void judge_euclidean() {
    Vector unit(model_.inverse_mass);
    for (double& weight : unit) weight = weight > 0.0 ? 1.0 : 0.0;
    GramSolver gamma(model_.incidences, unit, model_.numbering, Ordering::Auto,
                     model_.constraints.squared_gradient_norms());
    GramSolver g(model_.coordinates.list_products(unit),
                 {model_.coordinates.island_start(), model_.coordinates.num_coordinates()}, Ordering::Auto);
    const Vector &K = forms_.normal->blocks(), &A = forms_.tangent->blocks();
    gamma.assemble(model_.parallel, K.data());
    g.assemble(model_.parallel, A.data());
    const GramSolver::Quality a = gamma.factorize(model_.parallel), b = g.factorize(model_.parallel);
    if (!a.positive_definite || !b.positive_definite) return;
    judge_direct_problem(&gamma, unit, a.reciprocal_condition);
    const Vector u = random_points();
    Vector x(model_.coordinates.num_coordinates()), lambda(d_), sum(n_, 0.0);
    model_.coordinates.apply_transposed(model_.parallel, A.data(), u.data(), x.data());
    g.solve_negative(model_.parallel, x.data(), x.data());
    model_.coordinates.apply(model_.parallel, A.data(), x.data(), sum.data());  // -A G^-1 A'u
    model_.constraints.apply_transposed(model_.parallel, K.data(), u.data(), nullptr, lambda.data());
    gamma.solve_negative(model_.parallel, lambda.data(), lambda.data());
    model_.gather.add_scaled(model_.parallel, K.data(), lambda.data(), unit.data(), model_.num_moving(), sum.data());
    for (std::size_t i = 0; i < moving_; ++i) sum[i] += u[i];
    const double rcond = std::min(a.reciprocal_condition, b.reciprocal_condition);
    add_point(&result_.tangent_identity, "A G^-1 A' + K Gamma^-1 K' = I (15)",
              worst_point(sum, model_.largest_norm(u.data())), conditioned(rcond) + rounding_of_places());
  }

  /// Forces from the motion: K Gamma^-1 K'(M w - f) is eta, and nothing is left of M w - f.
  void judge_direct_problem(GramSolver* gamma, const Vector& unit, double reciprocal_condition) {
    Vector force(n_, 0.0), lambda(d_);
    for (std::size_t i = 0; i < moving_; ++i) force[i] = model_.mass[i / 3] * (answer_.w[i] - w0_[i]);
    const Vector& K = forms_.normal->blocks();
    model_.constraints.apply_transposed(model_.parallel, K.data(), force.data(), nullptr, lambda.data());
    gamma->solve_negative(model_.parallel, lambda.data(), lambda.data());
    model_.gather.add_scaled(model_.parallel, K.data(), lambda.data(), unit.data(), model_.num_moving(), force.data());
    for (std::size_t i = 0; i < moving_; ++i) force[i] *= model_.inverse_mass[i / 3];
    add_point(&result_.residual, "(M w - f)_T = 0, the direct problem", worst_point(force, acceleration_),
              conditioned(reciprocal_condition) + rounding_of_places());
  }

  /// First of all: then both forms stand at the answer.
  void solve_other() {
    other_w_.resize(n_);
    other_eta_.resize(n_);
    const Outcome outcome =
        forms_.solve_other(answer_.t, answer_.r.data(), answer_.v.data(), other_w_.data(), other_eta_.data());
    if (outcome.ok()) return;
    has_both_ = false;
    result_.checks.push_back({"the other form has an answer: " + outcome.what, Certificate::none, 0.0, ""});
  }

  void compare_forms() {
    Vector &w = other_w_, &eta = other_eta_;
    for (std::size_t i = 0; i < moving_; ++i) {
      w[i] -= answer_.w[i];
      eta[i] = model_.inverse_mass[i / 3] * (eta[i] - answer_.eta[i]);
    }
    const double allowed = 1e-10 + rounding_of_places();
    add_point(&result_.forms_agree, "w by A = w by K", worst_point(w, acceleration_), allowed);
    add_point(&result_.forms_agree, "eta by A = eta by K", worst_point(eta, acceleration_), allowed);
  }

  Forms& forms_;
  Model& model_;
  const Answer& answer_;
  const std::size_t n_, moving_, d_;
  Certificate result_;
  std::mt19937 generator_{20261};
  Vector w0_, user_r_, row_norms_, phi_, xi_t_;
  Vector other_w_, other_eta_;
  bool has_both_ = false;
  double rcond_of_S_ = 1.0, rcond_of_H_ = 1.0;
  double acceleration_ = 0.0;
};

}  // namespace

Certificate make_failed_certificate(const Outcome& outcome) {
  Certificate certificate;
  certificate.checks.push_back({"there is an answer: " + outcome.what, Certificate::none, 0.0, ""});
  return certificate;
}

Certificate certify(Forms& forms, const Answer& answer) {
  return Judge(forms, answer).judge();
}

}  // namespace tanor
