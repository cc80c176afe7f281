# SPDX-License-Identifier: GPL-3.0-or-later
"""Shots and sweeps on many machines, by engines that exist.

``atom``    starts one bake in Blender, reads its progress and names its end; needs nothing but Python
``shot``    bakes the chunks of a shot on a Dask cluster and joins them
``sweep``   solves meshes x poses x parameters on a Dask cluster, without Blender
``job``     the job type script of Flamenco, and the template of Open Job Description

The command ``sinew-farm`` reaches all of them but ``sweep``, which is for scripts.
"""
