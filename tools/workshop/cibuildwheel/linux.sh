#!/usr/bin/env bash
# SPDX-License-Identifier: GPL-3.0-or-later
# What the wheel build needs inside the manylinux container (AlmaLinux 8). Not yet run.
set -euo pipefail
dnf install -y epel-release
dnf config-manager --set-enabled powertools
dnf install -y suitesparse-devel openblas-devel openblas-threads tbb-devel eigen3-devel ninja-build ccache
