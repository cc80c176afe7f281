// SPDX-License-Identifier: GPL-3.0-or-later
// Bakes deformers of Sinew: a task for each chunk of frames, and one that joins them.
const JOB_TYPE = {
    label: "Sinew Bake",
    description: "Bake the Sinew deformers of objects into one cache file for each, on many workers",
    settings: [
        { key: "blendfile", type: "string", required: true, visible: "web", description: "The file, where all workers see it" },
        { key: "frames", type: "string", required: true, description: "Frames such as 1-240 or 1-240x2",
            eval: "f'{C.scene.frame_start}-{C.scene.frame_end}'", evalInfo: { showLinkButton: true, description: "Frames of the scene" } },
        { key: "chunk_size", type: "int32", default: 20, description: "Frames for each start of Blender" },
        { key: "objects", type: "string", required: true, description: "Names of objects, separated by commas",
            eval: "','.join(o.name for o in C.selected_objects)", evalInfo: { showLinkButton: true, description: "Selected objects" } },
        { key: "format", type: "string", default: "pc2", choices: ["pc2", "mdd", "alembic", "shape_keys"] },
        { key: "out", type: "string", subtype: "dir_path", required: true, description: "A folder that all workers see" },
        { key: "threads", type: "int32", default: 0, description: "Processor threads for each task; 0 for all" },
        { key: "memory", type: "float", default: 0, description: "Memory for each task in GB; 0 for no limit" },
        { key: "script", type: "string", subtype: "file_path", default: "", required: false,
            description: "For Blender before 4.2: farm/command.py of the add-on, where all workers see it" },
    ],
};

function compileJob(job) {
    const settings = job.settings;
    const bakes = chunks(settings.frames, settings.chunk_size).map((frames) => bakeTask(settings, frames));
    const join = author.Task("join", "blender");
    join.addCommand(start(settings, "join", [settings.out, "--frames", settings.frames], []));
    for (const bake of bakes) {
        job.addTask(bake);
        join.addDependency(bake);
    }
    job.addTask(join);
}

function bakeTask(settings, frames) {
    const task = author.Task(`bake-${frames}`, "blender");
    const limits = [];
    if (settings.threads > 0) limits.push("--threads", String(settings.threads));
    if (settings.memory > 0) limits.push("--memory", String(settings.memory));
    task.addCommand(start(settings, "bake", [settings.blendfile, "--frames", frames], limits));
    return task;
}

function start(settings, name, words, limits) {
    const way = settings.script ? ["--background", "--python", settings.script, "--", name] : ["--command", `sinew_${name}`];
    const common = ["--objects", settings.objects, "--format", settings.format, "--out", settings.out];
    return author.Command("exec", { exe: "{blender}", args: [].concat(way, words, common, limits) });
}

// Frames as Sinew writes them, in runs of a size: "1-5x2" in runs of 2 is "1-3x2", "5".
function chunks(frames, size) {
    const found = /^\s*(-?\d+)(?:-(-?\d+)(?:x([1-9]\d*))?)?\s*$/.exec(frames);
    if (!found || size < 1) throw `frames "${frames}", chunks of ${size}: write frames as 7, 1-24 or 1-24x2, and at least 1`;
    const first = Number(found[1]), last = Number(found[2] || found[1]), step = Number(found[3] || 1);
    if (last < first) throw `frames "${frames}": the last one is before the first one`;
    const runs = [];
    for (let at = first; at <= last; at += size * step) {
        const end = Math.min(at + (size - 1) * step, at + Math.floor((last - at) / step) * step);
        runs.push(at === end ? `${at}` : `${at}-${end}` + (step > 1 ? `x${step}` : ""));
    }
    return runs;
}
