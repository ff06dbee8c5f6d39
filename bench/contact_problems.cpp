#include "contact_problems.hpp"

#include <hdf5.h>

#include <algorithm>
#include <cstdio>
#include <fstream>
#include <stdexcept>
#include <string>
#include <vector>

#include <Eigen/Sparse>
#include <Eigen/SparseLU>

namespace tanor::bench {

namespace {

using Sparse = Eigen::SparseMatrix<double>;
using Triplets = std::vector<Eigen::Triplet<double>>;

[[noreturn]] void fail(const std::string& why) {
  throw std::runtime_error(why);
}

Sparse make(long rows, long columns, const Triplets& entries) {
  Sparse result(rows, columns);
  result.setFromTriplets(entries.begin(), entries.end());
  return result;
}

/// The matrices and vectors of a file: W and q, or M, H, f and w.
struct Given {
  int dimension = 3;
  bool is_global = false;
  Sparse W, M, H;
  Eigen::VectorXd q, f, w, mu;
};

// ---- text ----

class TextReader {
 public:
  explicit TextReader(std::istream& in) : in_(in) {}

  Given read(bool is_global) {
    Given given{.is_global = is_global};
    given.dimension = static_cast<int>(number());
    const long contacts = static_cast<long>(number()), rows = given.dimension * contacts;
    if (is_global) {
      given.M = matrix();
      given.H = matrix();
      given.f = vector(given.M.rows());
      given.w = vector(rows);
    } else {
      given.W = matrix();
      given.q = vector(rows);
    }
    given.mu = vector(contacts);
    return given;
  }

 private:
  double number() {
    std::string word;
    if (!(in_ >> word)) fail("it ends too early");
    return std::stod(word);
  }
  long integer() { return static_cast<long>(number()); }
  Eigen::VectorXd vector(long size) {
    Eigen::VectorXd result(size);
    for (double& each : result) each = number();
    return result;
  }
  Sparse matrix() {
    enum Storage { Dense = 0, Blocks = 1, Compressed = 2 };
    const long storage = integer(), rows = integer(), columns = integer();
    if (storage == Dense) return dense(rows, columns);
    return storage == Blocks ? blocks(rows, columns) : compressed(rows, columns);
  }
  Sparse dense(long rows, long columns) {
    if (integer() != rows || integer() != columns) fail("a matrix has two sizes");
    Triplets entries;
    for (long i = 0; i < rows; ++i)
      for (long j = 0; j < columns; ++j) entries.emplace_back(i, j, number());
    return make(rows, columns, entries);
  }
  Sparse blocks(long rows, long columns) {
    const long count = integer(), block_rows = integer(), block_columns = integer();
    std::vector<long> end_row{0}, end_column{0};
    for (long k = 0; k < block_rows; ++k) end_row.push_back(integer());
    for (long k = 0; k < block_columns; ++k) end_column.push_back(integer());
    const long filled_rows = integer(), filled = integer();
    std::vector<long> start, column;
    for (long k = 0; k < filled_rows; ++k) start.push_back(integer());
    for (long k = 0; k < filled; ++k) column.push_back(integer());
    Triplets entries;
    for (std::size_t row = 0; row + 1 < start.size(); ++row) {
      for (long k = start[row]; k < start[row + 1]; ++k) {
        if (integer() != k || k >= count) fail("a block has another number");
        const auto c = static_cast<std::size_t>(column[static_cast<std::size_t>(k)]);
        for (long j = end_column[c]; j < end_column[c + 1]; ++j)
          for (long i = end_row[row]; i < end_row[row + 1]; ++i) entries.emplace_back(i, j, number());
      }
    }
    return make(rows, columns, entries);
  }
  /// Reads what CSparse prints: "i j : x" of triplets, or "col j : locations a to b" and "i : x".
  Sparse compressed(long rows, long columns) {
    Triplets entries;
    long column = 0;
    bool is_triplet = false;
    std::string line;
    integer();
    std::getline(in_, line);
    std::getline(in_, line);  // the version
    std::getline(in_, line);  // sizes
    is_triplet = line.starts_with("triplet");
    long left = std::stol(line.substr(line.find("nnz: ") + 5)), row = 0;
    double x = 0.0;
    while (left > 0 && std::getline(in_, line)) {
      if (is_triplet ? std::sscanf(line.c_str(), "%ld %ld : %lf", &row, &column, &x) == 3
                     : std::sscanf(line.c_str(), " col %ld :", &column) != 1 &&
                           std::sscanf(line.c_str(), "%ld : %lf", &row, &x) == 2) {
        entries.emplace_back(row, column, x);
        --left;
      }
    }
    return make(rows, columns, entries);
  }

  std::istream& in_;
};

// ---- HDF5 ----

class FclibReader {
 public:
  explicit FclibReader(const std::filesystem::path& file) : file_(H5Fopen(file.c_str(), H5F_ACC_RDONLY, H5P_DEFAULT)) {
    if (file_ < 0) fail("it is no HDF5 file");
  }
  ~FclibReader() { H5Fclose(file_); }
  FclibReader(const FclibReader&) = delete;

  Given read() {
    Given given{.is_global = H5Lexists(file_, "fclib_global", H5P_DEFAULT) > 0};
    const std::string root = given.is_global ? "fclib_global/" : "fclib_local/";
    given.dimension = integers(root + "spacedim").front();
    if (given.is_global) {
      given.M = matrix(root + "M");
      given.H = matrix(root + "H");
      given.f = numbers(root + "vectors/f");
      given.w = numbers(root + "vectors/w");
    } else {
      given.W = matrix(root + "W");
      given.q = numbers(root + "vectors/q");
    }
    given.mu = numbers(root + "vectors/mu");
    return given;
  }

 private:
  template <class Number>
  std::vector<Number> array(const std::string& name, hid_t type) {
    const hid_t set = H5Dopen2(file_, name.c_str(), H5P_DEFAULT);
    if (set < 0) fail("it has no " + name);
    const hid_t space = H5Dget_space(set);
    std::vector<Number> result(static_cast<std::size_t>(H5Sget_simple_extent_npoints(space)));
    const bool is_read = H5Dread(set, type, H5S_ALL, H5S_ALL, H5P_DEFAULT, result.data()) >= 0;
    H5Sclose(space);
    H5Dclose(set);
    if (!is_read) fail(name + " cannot be read");
    return result;
  }
  std::vector<int> integers(const std::string& name) { return array<int>(name, H5T_NATIVE_INT); }
  Eigen::VectorXd numbers(const std::string& name) {
    const std::vector<double> all = array<double>(name, H5T_NATIVE_DOUBLE);
    return Eigen::Map<const Eigen::VectorXd>(all.data(), static_cast<long>(all.size()));
  }
  /// nz tells of triplets (its number), columns (-1) or rows (-2).
  Sparse matrix(const std::string& name) {
    const int rows = integers(name + "/m").front(), columns = integers(name + "/n").front(),
              kind = integers(name + "/nz").front();
    const std::vector<int> p = integers(name + "/p"), i = integers(name + "/i");
    const Eigen::VectorXd x = numbers(name + "/x");
    Triplets entries;
    if (kind >= 0) {
      for (int k = 0; k < kind; ++k)
        entries.emplace_back(i[static_cast<std::size_t>(k)], p[static_cast<std::size_t>(k)], x[k]);
    } else {
      for (int line = 0; line + 1 < static_cast<int>(p.size()); ++line) {
        for (int k = p[static_cast<std::size_t>(line)]; k < p[static_cast<std::size_t>(line) + 1]; ++k) {
          const int other = i[static_cast<std::size_t>(k)];
          kind == -1 ? entries.emplace_back(other, line, x[k]) : entries.emplace_back(line, other, x[k]);
        }
      }
    }
    return make(rows, columns, entries);
  }

  hid_t file_;
};

// ---- the problem ----

/// W = H'M^-1H and q = H'M^-1f + w.
void condense(Given* given) {
  Eigen::SparseLU<Sparse> solver(given->M);
  if (solver.info() != Eigen::Success) fail("M is singular");
  const Eigen::MatrixXd columns = solver.solve(Eigen::MatrixXd(given->H));
  given->W = (Eigen::MatrixXd(given->H).transpose() * columns).sparseView(1.0, 1e-300);
  given->q = given->H.transpose() * Eigen::VectorXd(solver.solve(given->f)) + given->w;
}

detail::ConeProblem in_blocks(const Given& given) {
  const long d = given.dimension, contacts = given.mu.size();
  if (d != 2 && d != 3) fail("it has neither two dimensions nor three");
  detail::ConeProblem problem;
  problem.friction.assign(given.mu.begin(), given.mu.end());
  problem.q.assign(static_cast<std::size_t>(3 * contacts), 0.0);
  for (long k = 0; k < given.q.size(); ++k) problem.q[static_cast<std::size_t>(3 * (k / d) + k % d)] = given.q[k];
  const Eigen::SparseMatrix<double, Eigen::RowMajor> W = given.W;
  const double free_tangent = given.W.diagonal().mean();
  for (long c = 0; c < contacts; ++c) {
    std::vector<int> columns{static_cast<int>(c)};
    for (long row = d * c; row < d * (c + 1); ++row)
      for (decltype(W)::InnerIterator entry(W, row); entry; ++entry)
        columns.push_back(static_cast<int>(entry.col() / d));
    std::sort(columns.begin(), columns.end());
    columns.erase(std::unique(columns.begin(), columns.end()), columns.end());
    const std::size_t first = problem.blocks.size();
    problem.blocks.resize(first + columns.size());
    for (long row = d * c; row < d * (c + 1); ++row) {
      for (decltype(W)::InnerIterator entry(W, row); entry; ++entry) {
        const auto at = std::lower_bound(columns.begin(), columns.end(), static_cast<int>(entry.col() / d));
        problem.blocks[first + static_cast<std::size_t>(at - columns.begin())]
            .entries[static_cast<std::size_t>(3 * (row % d) + entry.col() % d)] += entry.value();
      }
    }
    problem.columns.insert(problem.columns.end(), columns.begin(), columns.end());
    problem.start.push_back(problem.blocks.size());
    if (d == 2) const_cast<detail::Block3&>(problem.own_block(static_cast<std::size_t>(c))).entries[8] = free_tangent;
  }
  return problem;
}

}  // namespace

detail::ConeProblem read_contact_problem(const std::filesystem::path& file) {
  try {
    Given given;
    if (file.extension() == ".hdf5") {
      given = FclibReader(file).read();
    } else {
      std::ifstream in(file);
      const std::string name = file.filename().string();
      given = TextReader(in).read(name.starts_with("GFC") || name.starts_with("gfc"));
    }
    if (given.is_global) condense(&given);
    return in_blocks(given);
  } catch (const std::exception& error) {
    fail(file.string() + ": " + error.what());
  }
}

void write_contact_problem(const detail::ConeProblem& problem, const std::filesystem::path& file) {
  const std::size_t contacts = problem.num_contacts(), blocks = problem.blocks.size();
  const double scale = problem.scale();
  std::ofstream out(file);
  out.precision(17);
  out << "3\n" << contacts << "\n1\n" << 3 * contacts << "\n" << 3 * contacts << "\n";
  out << blocks << "\n" << contacts << "\n" << contacts << "\n";
  for (int side = 0; side < 2; ++side) {
    for (std::size_t c = 1; c <= contacts; ++c) out << 3 * c << " ";
    out << "\n";
  }
  out << contacts + 1 << "\n" << blocks << "\n";
  for (const std::size_t first : problem.start) out << first << " ";
  out << "\n";
  for (const int column : problem.columns) out << column << " ";
  out << "\n";
  for (std::size_t k = 0; k < blocks; ++k) {
    out << k << "\n";
    for (int entry = 0; entry < 9; ++entry) out << problem.blocks[k](entry % 3, entry / 3) / scale << "\n";
  }
  for (const double each : problem.q) out << each / scale << "\n";
  for (const double each : problem.friction) out << each << "\n";
}

}  // namespace tanor::bench
