#pragma once
/* Stands before the compiler's own header, which is for x86 alone: Eigen includes it where emscripten stands in for
 * SSE2 by WebAssembly's vectors, and needs nothing of it. Eigen takes inline assembly of x86 from what says that it is
 * some version of GCC, and compiler functions from what does not. Its sums then have the same lanes as on a PC, and so
 * the same bits. */
#undef EIGEN_COMP_GNUC
#define EIGEN_COMP_GNUC 0
