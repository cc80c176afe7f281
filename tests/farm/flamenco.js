// SPDX-License-Identifier: GPL-3.0-or-later
// What a job type sees of Flamenco: prints the tasks of a job with the settings that are given.
const Task = (name) => ({
    name,
    after: [],
    addCommand(command) { this.words = command.args; },
    addDependency(task) { this.after.push(task.name); },
});
const author = { Task, Command: (name, words) => words };
const tasks = [];
compileJob({ settings: JSON.parse(process.argv[1]), addTask: (task) => tasks.push(task) });
console.log(JSON.stringify(tasks));
