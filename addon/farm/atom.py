# SPDX-License-Identifier: GPL-3.0-or-later
"""What a farm starts: one bake or join, from its words to its exit status.

0 is done; 2: the words are not understood; 3: Sinew refuses the input; 4: there is too little memory or disk;
5: chunks of a join are missing or mixed. A process that ends otherwise has crashed, and may be tried again.
"""

import errno
import json
import signal
import sys
from collections.abc import Sequence
from contextlib import suppress

from ..core.errors import OutOfMemoryError, SinewError
from ..core.status import Remedy
from . import bake, join
from .words import WordsError, parse

ACTIONS = {"bake": bake.bake, "join": join.join}
DONE, WORDS, REFUSED, RESOURCES, INCOMPLETE, INTERRUPTED = 0, 2, 3, 4, 5, 130
_PATHS = {errno.EACCES, errno.EPERM, errno.ENOTDIR, errno.EISDIR, errno.EROFS, errno.ENAMETOOLONG}


def tell(kind: str, **values: object) -> None:
    """Write a line of progress for the program that started this one, which may have ended meanwhile.

    Blender itself may have written half a line before.
    """
    with suppress(OSError):
        sys.stdout.write(f"\n{json.dumps({'sinew': kind, **values})}\n")
        sys.stdout.flush()


def run(action: str, words: Sequence[str]) -> int:
    """Bake or join as the words say. Returns the exit status."""
    if hasattr(signal, "SIGXFSZ"):
        signal.signal(signal.SIGXFSZ, signal.SIG_IGN)  # a file that may not grow is an error, not the end
    try:
        ACTIONS.get(action, parse)(parse(action, words), tell)
    except SystemExit:  # --help was printed
        return DONE
    except WordsError as error:
        return _fail(str(error), WORDS)
    except SinewError as error:
        return _fail(str(error), _status_of(error))
    except MemoryError:
        return _fail("There is not enough memory for this shot", RESOURCES)
    except KeyboardInterrupt:
        return _fail("Interrupted", INTERRUPTED)
    return DONE


def _fail(message: str, code: int) -> int:
    tell("error", message=message, code=code)
    return code


def _status_of(error: SinewError) -> int:
    """A full disk is told from a path that is refused by the error of the system that came first."""
    if isinstance(error, join.IncompleteError):
        return INCOMPLETE
    if isinstance(error, OutOfMemoryError) or Remedy.PREFERENCES in error.remedy:
        return RESOURCES  # the module is there, so what the preferences can mend is the limit of memory
    first: BaseException = error
    while first.__cause__ is not None:
        first = first.__cause__
    is_disk = isinstance(first, OSError) and first.errno not in _PATHS
    return RESOURCES if is_disk or isinstance(first, MemoryError) else REFUSED
