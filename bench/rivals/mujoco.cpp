/// Runs MuJoCo with a fixed step.
///
///     rival_mujoco PROBLEM SIZE METHOD STEP FILE
///
/// METHOD: tree (a chain as a tree of ball joints), tendons (free beads, rods as equalities of tendons, which MuJoCo
/// keeps
/// by strong springs and dampers). Both use its Runge-Kutta method of order 4. STEP: s.

#include <mujoco/mujoco.h>

#include <memory>
#include <sstream>

#include "problem.hpp"

namespace rivals {
namespace {

/// The model's text: a main file and the files that it includes.
using Files = std::vector<std::pair<std::string, std::string>>;

std::string describe_options(const Problem& problem, double step, const std::string& solver, const std::string& off) {
  std::ostringstream text;
  text.precision(17);
  text << "<mujoco><compiler boundmass='0' boundinertia='0'/><size njmax='" << problem.rods.size() + 10
       << "' nconmax='1' nstack='100000000'/><option timestep='" << step
       << "' integrator='RK4' jacobian='sparse' gravity='0 0 " << -problem.gravity << "' " << solver << "><flag " << off
       << "/></option>";
  return text.str();
}

/// Returns the text of a bead at x of its body, m. MuJoCo takes no bead without a moment of inertia.
std::string describe_bead(const Problem& problem, double x, double inertia) {
  std::ostringstream text;
  text << "<inertial pos='" << x << " 0 0' mass='" << problem.mass << "' diaginertia='" << inertia << ' ' << inertia
       << ' ' << inertia << "'/>";
  return text.str();
}

/// Makes bodies within bodies, each turning about the bead before it. The reader takes no more than 100 levels a file.
Files make_tree(const Problem& problem, double step) {
  constexpr int levels = 80;
  const double inertia = problem.size() < 50 ? 1e-13 : 1e-11;  // kg m^2; with less, long chains give NaN
  const auto name = [](int part) { return "part" + std::to_string(part) + ".xml"; };
  Files files;
  for (int begin = 0; begin < problem.size(); begin += levels) {
    const int end = std::min(begin + levels, problem.size());
    std::ostringstream text;
    for (int i = begin; i < end; ++i) {
      text << "<body pos='" << (i > 0 ? problem.length : 0.0) << " 0 0'><joint type='ball'/>"
           << describe_bead(problem, problem.length, inertia);
    }
    if (end < problem.size()) text << "<include file='" << name(end / levels) << "'/>";
    for (int i = begin; i < end; ++i) text << "</body>";
    files.emplace_back(name(begin / levels), "<mujocoinclude>" + text.str() + "</mujocoinclude>");
  }
  const std::string options = describe_options(problem, step, "", "contact='disable' constraint='disable'");
  files.emplace_back("main.xml", options + "<worldbody><include file='" + name(0) + "'/></worldbody></mujoco>");
  return files;
}

/// Makes beads on three slides each, with a tendon between two sites for a rod.
Files make_tendons(const Problem& problem, double step) {
  std::ostringstream beads, rods, equalities;
  beads.precision(17);
  for (int i = 0; i < problem.size(); ++i) {
    const double* r = &problem.places[3 * i];
    beads << "<body pos='" << r[0] << ' ' << r[1] << ' ' << r[2] << "'><joint type='slide' axis='1 0 0'/>"
          << "<joint type='slide' axis='0 1 0'/><joint type='slide' axis='0 0 1'/>"
          << describe_bead(problem, 0.0, 1e-13) << "<site name='bead" << i << "'/></body>";
  }
  for (std::size_t k = 0; k < problem.rods.size(); ++k) {
    const Rod& rod = problem.rods[k];
    std::string from = "bead" + std::to_string(rod.i);
    if (rod.i < 0) {
      from = "anchor" + std::to_string(k);
      beads << "<site name='" << from << "' pos='" << rod.anchor[0] << ' ' << rod.anchor[1] << ' ' << rod.anchor[2]
            << "'/>";
    }
    rods << "<spatial name='rod" << k << "'><site site='" << from << "'/><site site='bead" << rod.j << "'/></spatial>";
    // The equality is the stiffest that the manual allows: a time constant of two steps, critically damped.
    equalities << "<tendon tendon1='rod" << k << "' solref='" << 2.0 * step << " 1' solimp='0.9999 0.9999 0.001'/>";
  }
  const std::string options =
      describe_options(problem, step, "solver='Newton' tolerance='1e-12' iterations='50'", "contact='disable'");
  return {{"main.xml", options + "<worldbody>" + beads.str() + "</worldbody><tendon>" + rods.str() +
                           "</tendon><equality>" + equalities.str() + "</equality></mujoco>"}};
}

using Model = std::unique_ptr<mjModel, decltype(&mj_deleteModel)>;

Model read_model(const Files& files) {
  const std::unique_ptr<mjVFS, void (*)(mjVFS*)> store(new mjVFS, [](mjVFS* vfs) {
    mj_deleteVFS(vfs);
    delete vfs;
  });
  mj_defaultVFS(store.get());
  for (const auto& [name, text] : files) {
    mj_makeEmptyFileVFS(store.get(), name.c_str(), static_cast<int>(text.size()));
    std::copy(text.begin(), text.end(), static_cast<char*>(store->filedata[mj_findFileVFS(store.get(), name.c_str())]));
  }
  char trouble[1000] = "";
  Model model(mj_loadXML("main.xml", store.get(), trouble, sizeof trouble), mj_deleteModel);
  if (!model) throw std::runtime_error(std::string("MuJoCo: ") + trouble);
  return model;
}

Run make_run(const Problem& problem, const std::string& method, double step) {
  const Model model = read_model(method == "tree" ? make_tree(problem, step) : make_tendons(problem, step));
  const std::unique_ptr<mjData, decltype(&mj_deleteData)> data(mj_makeData(model.get()), mj_deleteData);
  Run run;
  run.steps = std::lround(problem.t_end / step);
  const double begin = processor_time();
  for (long k = 0; k < run.steps; ++k) mj_step(model.get(), data.get());
  run.seconds = processor_time() - begin;
  mj_forward(model.get(), data.get());
  run.places.assign(data->xipos + 3, data->xipos + 3 * (problem.size() + 1));  // body 0 is the world
  // Where MuJoCo finds NaN, it warns and starts anew, so that the end is not that of the motion.
  for (const mjtWarning warning : {mjWARN_BADQPOS, mjWARN_BADQVEL, mjWARN_BADQACC}) {
    if (data->warning[warning].number > 0) std::fill(run.places.begin(), run.places.end(), std::nan(""));
  }
  return run;
}

}  // namespace
}  // namespace rivals

int main(int count, char** words) {
  // Otherwise MuJoCo writes a file of warnings and waits for a key before it ends.
  mju_user_warning = [](const char*) {};
  mju_user_error = [](const char* what) {
    std::fprintf(stderr, "%s\n", what);
    std::exit(1);
  };
  return rivals::drive(count, words, rivals::make_run);
}
