# SPDX-License-Identifier: GPL-3.0-or-later
# The files of kernels, each with the sets of instructions for which it is compiled beside the baseline.
set(SINEW_KERNELS
  native/core/simd/product_of_eight avx2
  native/handles/propagation_kernels avx2 avx512
  native/multiresolution/details/detail_kernels avx2
  native/operators/fit_kernels avx2
  native/riders/frame_kernels avx2
  native/rotations/body_kernels avx2
  native/rotations/graph_kernels avx2
  native/rotations/row_kernels avx2
  native/solvers/dense/kernels avx2 avx512
  native/solvers/descent/kernels avx2
  native/solvers/supernodal/kernels avx2
  native/space/cage/closed_forms/cage_kernels avx2 avx512
  native/space/cage/closed_forms/quad_kernels avx2 avx512
  native/space/cage/harmonic/layers avx2 avx512
  native/space/nonlinear/fields/field_kernels avx2 avx512
  native/space/lattice/grid/blend_kernels avx2 avx512
  native/space/nonlinear/mls/kernels avx2
  native/space/points/rbf/kernels avx2 avx512
  native/space/points/wires/wire_kernels avx2
  native/space/weights/products avx2
  native/subdivision/stencil_kernels avx2
  native/surface/nonlinear/pyramids/kernels avx2
)
