#pragma once

#include <span>
#include <string>
#include <vector>

#include <tanor/system.hpp>

#include "dynamics/corner_functions.hpp"
#include "dynamics/linearization.hpp"
#include "dynamics/projector.hpp"
#include "dynamics/tangent_linearization.hpp"
#include "dynamics/workspace.hpp"
#include "system/corner_terms.hpp"

namespace tanor::detail {

/// Corners of guides, and what a motion does there.
///
/// A guide has a corner where the argument u of a term passes 0. On a guide whose corner is rounded the normal turns
/// from that of one side to that of the other in the plane of both. The velocity relative to the edge turns with it, in
/// the M-norm and inside the other constraints, so that it keeps its length (and the energy, if nothing moves by
/// itself). With g = du/dx, the rate c = g'v + u_t at which u passes 0, and the velocity of the edge v0, c = 0:
///
///   e = P M^-1 g,   v0 = v - c e/(g'e),   v+ = v0 + c e+/sqrt(g'e g'e+)
///
/// P projects onto the tangents of all constraints on its side. In coordinates, M is A'MA, which jumps.
///
/// At an instant where rates xi_t jump, the normals stay, and v+ is the projection of v onto K'v + xi_t = 0 in the
/// M-norm.
class GuideCorners : public CornerFunctions {
 public:
  bool empty() const { return formulas_.empty() && functions_.empty(); }

  std::size_t num_terms() const final { return num_terms_; }
  void evaluate_terms(const Kinematics& at, double* arguments) final;
  void append_instants(double begin, double end, std::vector<double>* instants) final;
  Outcome cross(const Kinematics& before, const Kinematics& after, std::span<const std::size_t> which, double* v,
                Power* work) final;
  Outcome check_standing(const Kinematics& at, std::size_t term) final;
  std::string name_term(std::size_t term) const final;

 protected:
  explicit GuideCorners(Workspace& work) : work_(work), model_(work.model()) {}
  ~GuideCorners() = default;
  /// Adds the members of a formula, [member][number] their numbers in x.
  void add_formula(const Expression& expression, std::string name, std::vector<std::string> variables,
                   std::vector<std::size_t> numbers);
  void add_function(const ScalarFunction& function) {
    if (!function.is_constant()) functions_.push_back(function);
  }
  /// Adds all functions of time that a group of constraints or coordinates has.
  template <class Group>
  void add_functions(const Group& group);
  void add_supports();

  /// The passage of one edge: u_t, g [size] and e on both sides, whose first numbers are [size] as well.
  struct Edge {
    std::size_t term = 0;
    double u_t = 0.0;
    std::vector<double> g, before, after;
    double free = 0.0;  // g'e without constraints
  };
  // How the equations of motion respond, in their own variables.
  virtual std::size_t size() const = 0;
  /// Computes e of all edges at a state, and behind it what shows that sides differ.
  virtual Outcome respond(const Kinematics& at, std::span<Edge> edges, std::vector<double> Edge::*e) = 0;
  /// Makes v [size] a velocity on the other side: that before the corner, or what edges made of it if `is_turned`.
  virtual Outcome project(const Kinematics& before, const Kinematics& after, bool is_turned, double* v) = 0;
  /// Returns how far the points do not fit together on both sides, over the size of the scene.
  virtual double gap(const Kinematics& before, const Kinematics& after) = 0;
  virtual double kinetic_energy(const Kinematics& at) = 0;

  Workspace& work_;
  const Model& model_;

 private:
  struct Formula {
    CornerTerms terms;
    std::string name;
    std::vector<std::string> variables;
    std::vector<std::size_t> numbers;  // [member][number] in x
    std::size_t num_numbers() const { return terms.num_variables() - 1; }
    std::size_t num_members() const { return numbers.size() / num_numbers(); }
  };
  struct Place {
    const Formula* formula;
    std::size_t member, term;
  };

  Place find(std::size_t term) const;
  std::vector<double> load(const Formula& formula, std::size_t member, const Kinematics& at) const;
  Edge make_edge(std::size_t term, const Kinematics& at) const;
  Outcome find_edges(const Kinematics& before, const Kinematics& after, std::span<const std::size_t> which,
                     std::vector<Edge>* edges, std::vector<Edge>* held);
  Outcome check_rates(double t) const;
  Outcome check_apart(double t, const std::vector<Edge>& edges) const;
  Outcome check_order(const Kinematics& before, const Kinematics& after, const Edge& one, const Edge& other);
  Outcome turn(const Edge& edge, double t, const double* v_before, double* v) const;
  Outcome check_others(double t, const std::vector<Edge>& edges, std::span<const double> turned, const double* v) const;
  Outcome check_held(double t, const std::vector<Edge>& held, const double* v_before, const double* v) const;
  Outcome refuse(std::size_t term, double t, const std::string& why) const;

  std::vector<Formula> formulas_;
  std::vector<ScalarFunction> functions_;  // of time alone, that move guides and supports
  std::size_t num_terms_ = 0;
};

/// Corners where points step themselves.
class PointCorners final : public GuideCorners {
 public:
  PointCorners(Workspace& work, Linearization& linearization, Projector& projector);

  /// Moves the points r [3n] of a start that is exactly in corners by rounding, if v belongs to the branches that lie
  /// before it and not to those that hold at r.
  void choose_sides(double t, double* r, const double* v);

 private:
  std::size_t size() const override { return 3 * model_.num_points(); }
  Outcome respond(const Kinematics& at, std::span<Edge> edges, std::vector<double> Edge::*e) override;
  Outcome project(const Kinematics& before, const Kinematics& after, bool is_turned, double* v) override;
  double gap(const Kinematics& before, const Kinematics& after) override;
  double kinetic_energy(const Kinematics& at) override;

  Linearization& linearization_;
  Projector& projector_;
};

/// Corners where coordinates step.
class TangentCorners final : public GuideCorners {
 public:
  TangentCorners(Workspace& work, TangentLinearization& linearization);

 private:
  std::size_t size() const override { return work_.coordinates.num_coordinates(); }
  Outcome respond(const Kinematics& at, std::span<Edge> edges, std::vector<double> Edge::*e) override;
  Outcome project(const Kinematics& before, const Kinematics& after, bool is_turned, double* v) override;
  double gap(const Kinematics& before, const Kinematics& after) override;
  double kinetic_energy(const Kinematics& at) override;

  TangentLinearization& linearization_;
};

}  // namespace tanor::detail
