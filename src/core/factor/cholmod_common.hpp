#pragma once

#include <cholmod.h>

#include <new>

#include "base/check.hpp"
#include "factor/cholesky.hpp"

namespace tanor::detail {

/// A cholmod_common with every choice made by us.
struct CholmodCommon {
  cholmod_common c;

  CholmodCommon() {
    cholmod_start(&c);
    c.print = 0;
    c.final_ll = 1;  // LL', because with LDL' an indefinite matrix would pass as CHOLMOD_OK
    c.final_asis = 0;
    c.nmethods = 1;
    c.quick_return_if_not_posdef = 1;
    c.supernodal = CHOLMOD_SIMPLICIAL;
    c.method[0].ordering = CHOLMOD_NATURAL;
    c.postorder = 0;
  }
  ~CholmodCommon() { cholmod_finish(&c); }
  CholmodCommon(const CholmodCommon&) = delete;
  CholmodCommon& operator=(const CholmodCommon&) = delete;

  void check() const {
    if (c.status == CHOLMOD_OUT_OF_MEMORY || c.status == CHOLMOD_TOO_LARGE) throw std::bad_alloc();
    ensure(c.status >= CHOLMOD_OK, "CHOLMOD takes the matrices that we build");
  }
};

/// Returns CHOLMOD's view of our arrays. Nothing is copied. `stype` is -1 for a lower triangle, 1 for an upper one.
inline cholmod_sparse cholmod_view(const TrianglePattern& pattern, int stype, double* values = nullptr) {
  cholmod_sparse a{};
  a.nrow = a.ncol = pattern.size();
  a.nzmax = pattern.rows.size();
  a.p = const_cast<int*>(pattern.start.data());
  a.i = const_cast<int*>(pattern.rows.data());
  a.x = values;
  a.stype = stype;
  a.itype = CHOLMOD_INT;
  a.xtype = values != nullptr ? CHOLMOD_REAL : CHOLMOD_PATTERN;
  a.dtype = CHOLMOD_DOUBLE;
  a.sorted = 1;
  a.packed = 1;
  return a;
}

}  // namespace tanor::detail
