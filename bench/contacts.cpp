/// How far do the solvers of contacts come on problems of others, and what does it cost?
///
///     contacts FILE... [--seconds 10] [--write FOLDER]
///
/// Reads Siconos' text files and FCLIB's HDF5. Prints for each problem and each of the tolerances 1e-4, 1e-8 and 1e-12
/// the error, sweeps, factorizations and processor seconds, each from r = 0 on. Writes the problems, global ones
/// condensed, as Siconos' text instead, for bench/rivals/siconos_contacts.py.

#include <fmt/format.h>

#include <ctime>
#include <filesystem>
#include <string>
#include <vector>

#include "contact/cone_solver.hpp"
#include "contact_problems.hpp"

int main(int count, char** arguments) {
  using namespace tanor;
  std::vector<std::filesystem::path> files;
  std::filesystem::path folder;
  double seconds = 10.0;
  for (int k = 1; k < count; ++k) {
    if (std::string(arguments[k]) == "--seconds" && k + 1 < count)
      seconds = std::stod(arguments[++k]);
    else if (std::string(arguments[k]) == "--write" && k + 1 < count)
      folder = arguments[++k];
    else
      files.emplace_back(arguments[k]);
  }
  const std::vector<double> tolerances{1e-4, 1e-8, 1e-12};
  std::vector<int> solved(tolerances.size());
  std::vector<double> total(tolerances.size());
  for (const std::filesystem::path& file : files) {
    const detail::ConeProblem problem = bench::read_contact_problem(file);
    if (!folder.empty()) {
      bench::write_contact_problem(problem, folder / file.filename().replace_extension(".txt"));
      continue;
    }
    fmt::print("{:45} {:5}", file.stem().string(), problem.num_contacts());
    for (std::size_t k = 0; k < tolerances.size(); ++k) {
      std::vector<double> r(problem.q.size());
      const std::clock_t begin = std::clock();
      const detail::ConeReport report = solve_contacts(problem, {.tolerance = tolerances[k], .seconds = seconds}, &r);
      const double spent = static_cast<double>(std::clock() - begin) / CLOCKS_PER_SEC;
      solved[k] += report.is_solved ? 1 : 0;
      total[k] += spent;
      fmt::print(" | {}{:.1e} {:4} {:4} {:9.5f}", report.is_solved ? ' ' : 'x', report.error, report.sweeps,
                 report.factorizations, spent);
    }
    fmt::print("\n");
  }
  fmt::print("solved {}/{}/{} of {}, {:.3f} {:.3f} {:.3f} s\n", solved[0], solved[1], solved[2], files.size(), total[0],
             total[1], total[2]);
}
