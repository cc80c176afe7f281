# SPDX-License-Identifier: GPL-3.0-or-later
# The files of kernels, each with the sets of instructions for which it is compiled beside the baseline.
set(SINEW_KERNELS
  native/core/simd/product_of_eight avx2
  native/handles/propagation_kernels avx2 avx512
  native/methods/multiresolution/details/detail_kernels avx2
  native/operators/fits/fit_kernels avx2
  native/attachments/frames/frame_kernels avx2
  native/local_global/bodies/body_kernels avx2
  native/local_global/arap/arap_kernels avx2
  native/local_global/rows/row_kernels avx2
  native/solvers/dense/kernels avx2 avx512
  native/solvers/optimization/kernels avx2
  native/solvers/supernodal/kernels avx2
  native/methods/space/cage/closed_forms/cage_kernels avx2 avx512
  native/methods/space/cage/closed_forms/quad_kernels avx2 avx512
  native/methods/space/cage/harmonic/layers avx2 avx512
  native/methods/space/nonlinear/fields/field_kernels avx2 avx512
  native/methods/space/lattice/grid/blend_kernels avx2 avx512
  native/methods/space/nonlinear/mls/kernels avx2
  native/methods/space/points/rbf/kernels avx2 avx512
  native/methods/space/points/wires/wire_kernels avx2
  native/methods/space/weights/products avx2
  native/subdivision/stencil_kernels avx2
  native/methods/surface/nonlinear/pyramids/kernels avx2
)
