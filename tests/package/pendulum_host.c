/* A host program in C11: velocity Verlet of a pendulum released horizontally; exit code 1 if any answer is wrong.
 * Its points stand among those of others, in structs, the second one before the first. */
#include <math.h>
#include <stdio.h>
#include <tanor.h>

struct particle {
  int kind;
  double x[3], v[3];
};

static int check(int is_right, const char* what) {
  if (!is_right) printf("wrong: %s\n", what);
  return is_right ? 0 : 1;
}

int main(void) {
  const double length = 0.5, mass = 2.0, g = 9.81, dt = 1e-3;
  const double masses[2] = {INFINITY, 2.0};
  const int32_t index[2] = {2, 0}, pair[2] = {0, 1}, wrong_pair[2] = {0, 7};
  struct particle points[3] = {{1, {0.5, 0, 0}, {0, 0, 0}}, {2, {9, 9, 9}, {9, 9, 9}}, {1, {0, 0, 0}, {0, 0, 0}}};
  double old[9] = {0}, f[6] = {0}, tension = 0.0, lambda[1] = {0}, load = 0.0;
  size_t size = 1;
  tn_points x, v, none = {NULL, 0, NULL};
  tn_const_points x_now, v_now, x_old, forces;
  tn_wanted wanted = {0};
  tn_report report = {0};
  tn_options options = {0};
  tn_system* system = NULL;
  char name[32];
  int failures = 0, step, d;

  x.data = points[0].x, x.stride = sizeof(struct particle), x.index = index;
  v.data = points[0].v, v.stride = sizeof(struct particle), v.index = index;
  x_now.data = x.data, x_now.stride = x.stride, x_now.index = index;
  v_now.data = v.data, v_now.stride = v.stride, v_now.index = index;
  x_old.data = old, x_old.stride = 0, x_old.index = index;
  forces.data = f, forces.stride = 0, forces.index = NULL;
  wanted.size = sizeof(wanted);
  wanted.multipliers = lambda;
  wanted.measures = 1;
  report.size = sizeof(report);
  options.size = sizeof(options);
  options.threads = 1;
  f[5] = -mass * g;

  failures += check(tn_abi() == TN_ABI, "the header is that of the library");
  failures += check(tn_create(&system, 2, masses, x_now, &options) == TN_OK, tn_create_error());
  failures += check(tn_add_rods(system, 1, wrong_pair, NULL, NULL, NULL) == TN_EINVAL, "a pair of no points is refused");
  printf("refused: %s\n", tn_last_error(system));
  failures += check(tn_add_rods(system, 1, pair, NULL, NULL, NULL) == TN_OK, tn_last_error(system));
  failures += check(tn_num_rows(system) == 1 && tn_num_points(system) == 2, "one rod, two points");
  failures += check(tn_row_name(system, 0, name, sizeof(name)) == TN_OK && name[0] == 'r', "the rod has a name");

  for (step = 0; step < 1000 && failures == 0; ++step) {
    for (d = 0; d < 3; ++d) {
      old[d] = points[0].x[d];
      old[6 + d] = points[2].x[d];
      points[0].v[d] += 0.5 * dt * f[3 + d] / mass;
      points[0].x[d] += dt * points[0].v[d];
    }
    failures += check(tn_constrain_positions(system, dt, x_old, x, v, NULL, &report) == TN_OK, tn_last_error(system));
    failures += check(report.violation < 1e-13, "the rod keeps its length");
    for (d = 0; d < 3; ++d) points[0].v[d] += 0.5 * dt * f[3 + d] / mass;
    failures += check(tn_constrain_velocities(system, dt, x_now, v, NULL, NULL) == TN_OK, tn_last_error(system));
  }
  {
    const double speed2 = points[0].v[0] * points[0].v[0] + points[0].v[2] * points[0].v[2];
    const double energy = 0.5 * mass * speed2 + mass * g * points[0].x[2];
    failures += check(fabs(energy) < 1e-4, "the energy stays");
    failures += check(tn_solve(system, x_now, v_now, forces, none, &wanted, &report) == TN_OK, tn_last_error(system));
    /* What turns the bob, and what its weight leaves to the rod. */
    tension = mass * speed2 / length - mass * g * points[0].x[2] / length;
    failures += check(fabs(-lambda[0] - tension) < 1e-10 * tension, "the tension is m v^2/l + m g cos");
    failures += check(tn_add_observable(system, "load(support0).norm", NULL) == TN_OK, tn_last_error(system));
    failures += check(tn_observe(system, 1.0, x_now, v_now, forces, none, NULL, NULL) == TN_OK, tn_last_error(system));
    failures += check(tn_observed(system, 0, &load, &size) == TN_OK, tn_last_error(system));
    failures += check(fabs(load - tension) < 1e-10 * tension, "the support carries the tension");
    printf("the support carries %.3f N\n", load);
    failures += check(fabs(report.virial[0] + report.virial[1] + report.virial[2] - lambda[0] * length) <
                          1e-10 * tension * length,
                      "the virial is lambda L");
  }
  failures += check(points[1].x[0] == 9 && points[1].v[2] == 9, "strangers are left alone");
  points[0].x[0] = NAN;
  failures += check(tn_violation(NULL, x_now, &report) == TN_EINVAL, "no system is no crash");
  failures += check(tn_constrain_velocities(system, dt, x_now, v, NULL, NULL) == TN_NOT_FINITE, "NaN is seen");
  tn_destroy(system);
  tn_destroy(NULL);
  printf(failures == 0 ? "a C host is served\n" : "%d answers are wrong\n", failures);
  return failures == 0 ? 0 : 1;
}
