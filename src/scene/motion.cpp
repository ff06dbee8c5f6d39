#include "scene/motion.hpp"

#include <limits>

namespace tanor::scene {
namespace {

CertificatePolicy read_certificate(const Cursor& certificate) {
  using When = CertificatePolicy::When;
  constexpr int most = std::numeric_limits<int>::max();
  if (certificate.is_object())
    return {When::Every, static_cast<int>(certificate.object({"every"})["every"].integer(1, most))};
  if (certificate && !certificate.is_string()) certificate.fail(R"("off", "final", "always" or {"every": N})");
  return {certificate.choice<When>({{"off", When::Off}, {"final", When::Final}, {"always", When::Always}}, When::Final),
          0};
}

}  // namespace

void read_motion(const Cursor& motion, const Context& context, Scene* scene) {
  motion.object({"method", "step", "rtol", "atol", "t_end", "output_every", "output_points", "stabilisation", "start"});
  MotionOptions& options = scene->motion;
  if (const Cursor method = motion["method"]) {
    const std::string& name = method.string();
    options.method = method.locate([&] { return method_from_name(name); });
  }
  if (!motion["step"].is_null()) options.step = motion["step"].positive(0.0);
  options.rtol = motion["rtol"].positive(options.rtol);
  options.atol = motion["atol"].positive(options.atol);
  options.stabilisation = motion["stabilisation"].choice<Stabilisation>(
      {{"projection", Stabilisation::Projection}, {"none", Stabilisation::None}}, options.stabilisation);
  options.start =
      motion["start"].choice<StartMode>({{"check", StartMode::Check}, {"project", StartMode::Project}}, options.start);

  scene->t_end = motion["t_end"].non_negative(0.0);
  scene->output_every = motion["output_every"].positive(0.0);
  if (const Cursor points = motion["output_points"]; points && !points.says("all"))
    scene->output_points = context.points(points);
}

void read_solver(const Cursor& solver, Scene* scene) {
  solver.object({"form", "ordering", "threads", "certificate"});
  solver["form"].choice<int>({{"auto", 0}, {"normal", 0}}, 0, {"tangent", "both"});
  scene->solver.ordering = solver["ordering"].choice<Ordering>({{"auto", Ordering::Auto},
                                                                {"amd", Ordering::Amd},
                                                                {"metis", Ordering::Metis},
                                                                {"nesdis", Ordering::Nesdis},
                                                                {"natural", Ordering::Natural}},
                                                               scene->solver.ordering);
  scene->solver.threads = static_cast<int>(solver["threads"].integer(0, std::numeric_limits<int>::max(), 0));
  scene->certificate = read_certificate(solver["certificate"]);
}

}  // namespace tanor::scene
