// SPDX-License-Identifier: GPL-3.0-or-later
// Browsers give no workers to pages that are opened from a disk, and the search is one: there it runs in a hidden frame.
if (location.protocol === "file:")
    window.Worker = class extends EventTarget {
        constructor(url) {
            super();
            const frame = document.createElement("iframe");
            frame.hidden = true;
            this.scope = new Promise((resolve) => {
                frame.onload = () => {
                    const scope = frame.contentWindow;
                    scope.postMessage = (data) => this.dispatchEvent(new MessageEvent("message", { data }));
                    const script = scope.document.createElement("script");
                    script.src = new URL(url, location.href);
                    script.onload = () => resolve(scope);
                    scope.document.body.append(script);
                };
            });
            document.documentElement.append(frame);
        }

        postMessage(data) {
            this.scope.then((scope) => scope.dispatchEvent(new MessageEvent("message", { data })));
        }
    };
