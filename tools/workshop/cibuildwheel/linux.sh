#!/usr/bin/env bash
# SPDX-License-Identifier: GPL-3.0-or-later
# What the wheel build needs inside the manylinux container (AlmaLinux 8). Not yet run.
set -euo pipefail
dnf install -y epel-release
dnf config-manager --set-enabled powertools
dnf install -y suitesparse-devel openblas-devel openblas-threads tbb-devel eigen3-devel boost-devel ninja-build ccache

# Neither of these is packaged there in a version that is new enough.
sources=$(mktemp -d)
trap 'rm -rf "$sources"' EXIT
curl -sSL https://github.com/PixarAnimationStudios/OpenSubdiv/archive/refs/tags/v3_5_0.tar.gz | tar -xz -C "$sources"
cmake -S "$sources"/OpenSubdiv-3_5_0 -B "$sources"/build -G Ninja -D CMAKE_BUILD_TYPE=Release \
    -D NO_LIB_GPU=1 -D NO_{EXAMPLES,TUTORIALS,REGRESSION,DOC,OMP,TBB,CUDA,OPENCL,OPENGL,CLEW,GLFW,PTEX,TESTS,GLTESTS}=1
cmake --build "$sources"/build --target install
curl -sSL https://github.com/CGAL/cgal/releases/download/v5.5.1/CGAL-5.5.1-library.tar.xz | tar -xJ -C "$sources"
cp -r "$sources"/CGAL-5.5.1/include/CGAL /usr/local/include/
