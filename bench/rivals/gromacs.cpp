/// Runs GROMACS in double precision: velocity Verlet with LINCS and a fixed step. It is a program of its own that works
/// on
/// files, and the time is the wall time that it reports, in milliseconds.
///
///     rival_gromacs PROBLEM SIZE lincs STEP FILE       STEP: s

#include <filesystem>
#include <fstream>
#include <iomanip>
#include <iterator>
#include <sstream>

#include "problem.hpp"

namespace rivals {
namespace {

/// Writes the files. GROMACS' nm, ps, u stand for our m, s, kg; `box` keeps the periodic images away. Anchors are the
/// residue ANCHR, after the beads.
void write_files(const Problem& problem, double step, double box) {
  std::vector<double> r = problem.places;
  std::ofstream options("options.mdp"), places("places.g96"), topology("topology.top");
  topology << "[ defaults ]\n1 1 no 1 1\n[ atomtypes ]\nA 18 " << problem.mass
           << " 0 A 0 0\n[ moleculetype ]\nM 2\n[ atoms ]\n";
  std::ostringstream constraints;
  for (const Rod& rod : problem.rods) {
    if (rod.i < 0) r.insert(r.end(), rod.anchor.begin(), rod.anchor.end());
    const std::size_t from = rod.i < 0 ? r.size() / 3 : static_cast<std::size_t>(rod.i + 1);
    constraints << from << ' ' << rod.j + 1 << " 1 " << problem.length << '\n';
  }
  places << std::fixed << std::setprecision(9) << "TITLE\nM\nEND\nPOSITION\n";
  for (std::size_t i = 0; i < r.size() / 3; ++i) {
    const char* name = i < problem.places.size() / 3 ? "BEAD " : "ANCHR";
    topology << i + 1 << " A 1 " << name << " A " << i + 1 << " 0\n";
    places << "    1 " << name << " A    " << std::setw(7) << i + 1;
    for (int c = 0; c < 3; ++c) places << std::setw(15) << r[3 * i + c] + 0.5 * box;
    places << '\n';
  }
  places << "END\nBOX\n" << std::setw(15) << box << std::setw(15) << box << std::setw(15) << box << "\nEND\n";
  topology << "[ constraints ]\n" << constraints.str() << "[ system ]\nM\n[ molecules ]\nM 1\n";
  options << "integrator = md-vv\nconstraint-algorithm = lincs\nlincs-order = 8\nlincs-iter = 4\nlincs-warnangle = 90\n"
          << "dt = " << step << "\nnsteps = " << std::lround(problem.t_end / step) << "\ncontinuation = yes\n"
          << "nstlist = 1000\nverlet-buffer-tolerance = -1\nrlist = 0.03\nrcoulomb = 0.03\nrvdw = 0.03\n"
          << "coulombtype = cut-off\ncomm-mode = none\nnstenergy = 0\nnstlog = 0\nnstcalcenergy = 0\n"
          << "freezegrps = ANCHR\nfreezedim = Y Y Y\nacc-grps = BEAD\naccelerate = 0 0 " << -problem.gravity << '\n';
}

void call(const std::string& command) {
  if (std::system((command + " >output.txt 2>&1").c_str()) != 0) throw std::runtime_error("GROMACS: " + command);
}

/// Returns the file, open after the last of these words.
std::ifstream find_last(const std::string& file, const std::string& words) {
  std::ifstream in(file);
  const std::string text{std::istreambuf_iterator<char>(in), {}};
  const std::size_t found = text.rfind(words);
  if (found == std::string::npos) throw std::runtime_error("GROMACS: nothing in " + file);
  in.clear();
  in.seekg(static_cast<std::streamoff>(found + words.size()));
  return in;
}

/// A working folder that is removed at the end.
struct Folder {
  std::filesystem::path home = std::filesystem::current_path();
  std::string name = std::filesystem::temp_directory_path() / "rival_gromacs_XXXXXX";

  Folder() {
    if (!mkdtemp(name.data())) throw std::runtime_error("no folder " + name);
    std::filesystem::current_path(name);
  }
  ~Folder() {
    std::filesystem::current_path(home);
    std::filesystem::remove_all(name);
  }
};

Run make_run(const Problem& problem, const std::string& /*method*/, double step) {
  const Folder folder;
  const double box = 4.0 + 2.0 * problem.length * problem.size();
  write_files(problem, step, box);
  call("gmx_d grompp -f options.mdp -c places.g96 -p topology.top -maxwarn 10");
  call("GMX_MAXCONSTRWARN=-1 timeout 50 gmx_d mdrun -ntmpi 1 -ntomp 1 -pin off -nb cpu -c end.g96");
  Run run;
  run.steps = std::lround(problem.t_end / step);
  find_last("md.log", " Time:") >> run.seconds;
  std::ifstream end = find_last("end.g96", "POSITION\n");
  std::string residue_number, residue, atom, number;
  for (std::size_t i = 0; i < problem.places.size(); i += 3) {
    end >> residue_number >> residue >> atom >> number;
    for (int c = 0; c < 3; ++c) {
      double coordinate = std::nan("");
      end >> coordinate;
      run.places.push_back(coordinate - 0.5 * box);
    }
  }
  return run;
}

}  // namespace
}  // namespace rivals

int main(int count, char** words) {
  return rivals::drive(count, words, rivals::make_run);
}
