// The functions of OpenCL C that kernels call, as clang's opencl-c.h declares them. PoCL reads that
// header of 18 000 lines for every program, a compiled one as well, unless its guard _OPENCL_H_ is
// defined (device.py). Where a PoCL reads it all the same, these lines only repeat declarations.
#ifndef __AVX__
// Such a processor holds vectors by halves, which matters to those who call functions from outside.
#pragma clang diagnostic ignored "-Wpsabi"
#endif
#define CONST __attribute__((overloadable, const))
#define UNARY(name) double CONST name(double); double4 CONST name(double4)
UNARY(exp);
UNARY(expm1);
UNARY(fabs);
UNARY(log);
UNARY(log1p);
UNARY(sqrt);
double CONST fmax(double, double);
double CONST fmin(double, double);
double CONST hypot(double, double);
int CONST isfinite(double);
int CONST min(int, int);
size_t CONST get_group_id(uint);
size_t CONST get_local_id(uint);
int __attribute__((overloadable)) atomic_inc(volatile __global int *);
void __attribute__((overloadable, convergent)) barrier(cl_mem_fence_flags);
#undef UNARY
#undef CONST
