#!/usr/bin/env python3
"""Checks the prose of documents, OpenAPI descriptions and C++ comments.

Lines have at most 100 columns, sentences at most 30 words, and words that hide the meaning are
banned, each with a reason. Quoted code (`like this`), code blocks, link targets and names such as
`floor_map` are exempt, so wire names and identifiers stay as they are.

  prose_test.py SOURCE_DIR   prints each finding as file:line: message; exit code 1 if there is any
  prose_test.py --self-test  checks the checker on a text that must fail and one that must pass

Needs only the standard library of Python 3.
"""

import pathlib
import re
import sys
from typing import Iterator, NamedTuple

MAX_COLUMNS = 100
MAX_WORDS = 30

DOCUMENTS = ["README.md", "CHANGELOG.md", "CONTRIBUTING.md", "docs/**/*.md", "bench/*/*.md"]
DESCRIPTIONS = ["api/openapi.yaml"]
CODE_FOLDERS = ["core", "evaluation", "storage", "api", "server", "frames", "ros2", "clients", "cli",
                "bench", "tests", "docs/examples"]
CODE_SUFFIXES = {".hpp", ".cpp"}

# Not a letter, digit, "_", "/", "." or "-" beside the word: names of files and code are no words.
WORD = r"(?<![\w/.-]){}(?![\w/-])"

# Pattern and reason. The patterns match words of prose only; see strip_code().
BANNED = [
    (r"tells?|told|telling", "name the subject: shows, states, distinguishes, is given"),
    (r"(?:say|says|said|saying) (?:of|nothing|something|by themselves)", "use states or measures"),
    (r"knows? of itself", "name what is known"),
    (r"whatever|whoever", "name the cases"),
    (r"(?:be|are|is) had", "use select, get or set"),
    (r"of which", "write two sentences"),
    (r"look-?alikes?", "aliased poses"),
    (r"floor[ -]maps?", "occupancy map"),
    (r"two[ -]arms?|two-armed", "line-intersection corner"),
    (r"(?<!a )(?<!the )beam ends?|ends of beams?", "hits"),
    (r"key[ -]frames?", "keyframe"),
    (r"hard (?:areas?|places?)", "low-localizability region"),
    (r"virtual (?:lidars?|scans?)", "simulated scan"),
    (r"(?:a|an|the|this|that|each|every|another|whole|one|new|later|earlier|first|newest|mapping"
     r"|recorded|simulated) drives?(?= of| by| in| at| that| whose| is| was| has| into| to|[,.;:)]|$)",
     "run, as a noun"),
    (r"(?:a|the|no|its|each|first|false|new) fix(?:es)?", "accepted pose, or localized"),
    (r"(?:metres?|m) of way|way to the fix|length of the way", "path length"),
    (r"taken back", "withdrawn"),
    (r"speaks? for", "supports, or is valid for"),
    (r"honestly", "state what is answered"),
]
BANNED = [(re.compile(WORD.format(f"(?:{words})"), re.IGNORECASE), reason)
          for words, reason in BANNED]

ABBREVIATIONS = re.compile(
    r"\b(?:e\.g|i\.e|et al|eqs?|vs|figs?|cf|approx|no|sec|ca|resp|Dr)\.$", re.IGNORECASE)


class Line(NamedTuple):
    number: int
    text: str


class Block(NamedTuple):
    """Lines that form one piece of running text, such as a paragraph or a table cell."""
    lines: list[Line]


class Finding(NamedTuple):
    path: str
    line: int
    message: str

    def __str__(self) -> str:
        return f"{self.path}:{self.line}: {self.message}"


# --- what is prose in a file


def strip_code(text: str) -> str:
    """Inline code and links become one word or their text."""
    text = re.sub(r"!?\[([^\]]*)\]\([^)]*\)", r"\1", text)
    text = re.sub(r"``.+?``|`[^`]*`", "CODE", text)
    text = re.sub(r"<?https?://\S+>?", "LINK", text)
    return text.replace("**", "").replace("*", "")


def markdown_blocks(text: str) -> tuple[list[Block], list[Line]]:
    """The blocks of a Markdown text, and the lines whose width counts."""
    blocks: list[Block] = []
    wide: list[Line] = []
    current: list[Line] = []
    fence = ""

    def end_block() -> None:
        if current:
            blocks.append(Block(current.copy()))
        current.clear()

    for number, raw in enumerate(text.splitlines(), 1):
        stripped = raw.strip()
        marker = re.match(r"(```+|~~~+)", stripped)
        if fence or marker:
            end_block()
            if not fence:
                fence = marker[1]
            elif stripped.startswith(fence):
                fence = ""
            continue
        is_indented_code = raw.startswith("    ") and not current
        if not stripped or is_indented_code:
            end_block()
            continue
        if stripped.startswith("|"):
            end_block()
            for cell in re.split(r"(?<!\\)\|", stripped.strip("|")):
                blocks.append(Block([Line(number, cell)]))
            continue
        is_picture = stripped.startswith("![")
        if not is_picture and ("](" not in raw or len(re.sub(r"\]\([^)]*\)", "]", raw)) > MAX_COLUMNS):
            wide.append(Line(number, raw))
        if re.match(r"#+ |[-*+] |\d+\. ", stripped):
            end_block()
        current.append(Line(number, re.sub(r"^(?:#+|[-*+]|\d+\.|>) ", "", stripped)))
        if stripped.startswith("#"):
            end_block()
    end_block()
    return blocks, wide


def yaml_descriptions(text: str) -> tuple[list[Block], list[Line]]:
    """The values of `description` and `summary` in an OpenAPI document, block or inline."""
    blocks: list[Block] = []
    wide: list[Line] = []
    lines = text.splitlines()
    index = 0
    while index < len(lines):
        raw = lines[index]
        number = index + 1
        index += 1
        comment = re.match(r"\s*# (.*)", raw)
        if comment:
            blocks.append(Block([Line(number, comment[1])]))
            wide.append(Line(number, raw))
            continue
        for inline in re.finditer(r"[{,] (?:description|summary): (?:'((?:[^']|'')*)'|([^'\",}][^',}]*))",
                                  raw):
            blocks.append(Block([Line(number, inline[1] or inline[2])]))
            wide.append(Line(number, raw))
        key = re.match(r"(\s*)(?:- )?(?:description|summary): (.*)", raw)
        if not key:
            continue
        body: list[str] = []
        while index < len(lines) and (not lines[index].strip() or
                                      len(lines[index]) - len(lines[index].lstrip()) > len(key[1])):
            body.append(lines[index])
            index += 1
        if key[2].startswith('"'):  # an example
            continue
        if key[2][:1] in "|>" and key[2]:
            found, found_wide = markdown_blocks("\n".join(line.strip() for line in body))
            blocks += [Block([Line(line.number + number, line.text) for line in block.lines])
                       for block in found]
            wide += [Line(number + 1 + i, line) for i, line in enumerate(body)]
        elif not key[2].startswith("{"):
            first = Line(number, key[2].strip("'\""))
            rest = [Line(number + 1 + i, line.strip()) for i, line in enumerate(body)]
            blocks.append(Block([first, *rest]))
            wide += [Line(number, raw), *(Line(number + 1 + i, l) for i, l in enumerate(body))]
    return blocks, wide


STRING = re.compile(r'R"([^(]*)\(.*?\)\1"|"(?:[^"\\\n]|\\.)*"|\'(?:[^\'\\\n]|\\.)+\'', re.DOTALL)


def comment_blocks(text: str) -> tuple[list[Block], list[Line]]:
    """The comments of a C++ file."""
    def blank(match: re.Match[str]) -> str:
        return re.sub(r"[^\n]", "_", match[0])

    # Strings may hold "//"; comments may hold quotes. Strings that begin inside a comment stay.
    pattern = re.compile(r"(//[^\n]*)|(/\*.*?\*/)|(?<![0-9A-Fa-f])(?:" + STRING.pattern.replace(
        r"\1", r"\3") + ")", re.DOTALL)
    bare = pattern.sub(lambda m: m[0] if m[1] or m[2] else blank(m), text)
    blocks: list[Block] = []
    wide: list[Line] = []
    current: list[Line] = []
    column = -1

    def end_block() -> None:
        if current:
            blocks.append(Block(current.copy()))
        current.clear()

    for number, raw in enumerate(bare.splitlines(), 1):
        found = re.search(r"//+<? ?(.*)", raw)
        if not found:
            end_block()
            continue
        wide.append(Line(number, raw))
        words = found[1].strip()
        is_alone = not raw[:found.start()].strip()
        if not is_alone or (found.start() != column and current):
            end_block()
        column = found.start()
        if re.match(r"clang-format|NOLINT|-{3,}|--- ", words) or not words:
            end_block()
            continue
        if re.match(r"[\\@]\w+|[-*] |\d+\. ", words):
            end_block()
            words = re.sub(r"^(?:[\\@]param(?:\[\w+\])? \w+|[\\@]\w+|[-*]|\d+\.)\s*", "", words)
        current.append(Line(number, words))
    end_block()
    return blocks, wide


# --- rules


def sentences(block: Block) -> Iterator[tuple[int, str]]:
    """Sentences of a block, each with the number of the line in which it begins."""
    words: list[str] = []
    first = 0
    # Code is stripped over the whole block, because it may span lines.
    marked = "\n".join(line.text for line in block.lines)
    numbers = [line.number for line in block.lines]
    stripped = strip_code(marked)
    # Links and code that span lines lose line breaks; later numbers are then a little early.
    for index, line in enumerate(stripped.split("\n")):
        for word in line.split():
            if not words:
                first = numbers[min(index, len(numbers) - 1)]
            words.append(word)
            end = word.rstrip("\"')]")
            if end[-1:] in (".", "!", "?", "…") and not ABBREVIATIONS.search(" ".join(words)[-8:]) \
                    and not re.fullmatch(r"[A-Z]\.", end):
                yield first, " ".join(words)
                words = []
    if words:
        yield first, " ".join(words)


def word_count(sentence: str) -> int:
    return sum(1 for word in sentence.split() if re.search(r"\w", word))


def check(path: str, blocks: list[Block], wide: list[Line]) -> list[Finding]:
    findings = [Finding(path, line.number, f"{len(line.text)} columns, at most {MAX_COLUMNS}")
                for line in wide if len(line.text) > MAX_COLUMNS]
    for block in blocks:
        for number, sentence in sentences(block):
            count = word_count(sentence)
            if count > MAX_WORDS:
                findings.append(Finding(
                    path, number, f"{count} words in a sentence, at most {MAX_WORDS}: "
                    f"\"{sentence[:60]} ...\""))
            for pattern, reason in BANNED:
                for match in pattern.finditer(sentence):
                    findings.append(Finding(path, number, f"\"{match[0]}\": {reason}"))
    return findings


def check_text(path: str, text: str) -> list[Finding]:
    suffix = pathlib.PurePath(path).suffix
    parse = {".md": markdown_blocks, ".yaml": yaml_descriptions}.get(suffix, comment_blocks)
    return check(path, *parse(text))


def files_of(source: pathlib.Path) -> Iterator[pathlib.Path]:
    for pattern in DOCUMENTS + DESCRIPTIONS:
        yield from sorted(source.glob(pattern))
    for folder in CODE_FOLDERS:
        yield from (path for path in sorted((source / folder).rglob("*"))
                    if path.suffix in CODE_SUFFIXES)


def check_tree(source: pathlib.Path) -> int:
    files = list(files_of(source))
    findings = [finding for path in files
                for finding in check_text(str(path.relative_to(source)),
                                          path.read_text(encoding="utf-8"))]
    for finding in findings:
        print(finding)
    print(f"{len(findings)} findings in {len(files)} files")
    return 1 if findings or len(files) < 10 else 0


# --- the checker itself

LONG = "word " * MAX_WORDS + "word."
LINES = "word " * 15 + "\n" + "word " * (MAX_WORDS - 16) + "word."

BAD = {
    "long sentence": ("a.md", LONG),
    "long sentence over lines": ("a.md", LONG.replace("word word", "word\nword")),
    "long sentence in a list": ("a.md", "- Short one.\n- " + LONG),
    "long sentence in a table": ("a.md", "| a | " + LONG + " |"),
    "wide line": ("a.md", "x" * (MAX_COLUMNS + 1)),
    "wide line with a short link": ("a.md", "x" * (MAX_COLUMNS + 1) + " [a](b)"),
    "wide comment": ("a.hpp", "/// " + "x" * MAX_COLUMNS),
    "wide comment after code": ("a.hpp", "int a = 0;  ///< " + "x" * MAX_COLUMNS),
    "long sentence in a comment": ("a.hpp", "/// " + LONG.replace("word word", "word\n/// word")),
    "banned word in a comment": ("a.cpp", "const char* a = \"//\";  // told"),
    "banned word in OpenAPI": ("a.yaml", "  description: |\n    Text.\n\n    It tells all."),
    "banned word in flow style": ("a.yaml", "a: {type: number, description: 'A floor map.'}"),
    "long sentence in OpenAPI": ("a.yaml", "  description: " + LONG),
    "banned noun": ("a.md", "Make the map from a drive."),
    "banned fix": ("a.md", "It waits for a fix."),
}

GOOD = {
    "short sentences": ("a.md", "Read e.g. this.\n" + LINES + "\n\n" + LINES),
    "code block": ("a.md", "```\n" + LONG + " told " + "x" * MAX_COLUMNS + "\n```\nText."),
    "inline code": ("a.md", "The column `floor_map` and the `two-arm` corner."),
    "file names": ("a.md", "See drive.jsonl.gz and mapping_drive.hpp of it."),
    "link": ("a.md", "See [the page](" + "x" * MAX_COLUMNS + ") for it."),
    "verb": ("a.md", "Drive on. The robots drive to the door and a robot drives on."),
    "string": ("a.cpp", "const char* a = \"// told\";  // Fine."),
    "flow style": ("a.yaml", "a: {type: number, description: 'It''s fine.'}"),
    "list": ("a.md", "- " + LINES + "\n- " + LINES),
    "picture": ("a.md", "![" + "word " * 25 + "](a.png)"),
}


def self_test() -> int:
    failures = [f"no finding: {name}" for name, (path, text) in BAD.items()
                if not check_text(path, text)]
    failures += [f"{name}: {finding}" for name, (path, text) in GOOD.items()
                 for finding in check_text(path, text)]
    for failure in failures:
        print(failure)
    print(f"{len(BAD)} bad and {len(GOOD)} good texts, {len(failures)} failures")
    return 1 if failures else 0


def main() -> int:
    if len(sys.argv) != 2:
        print(__doc__)
        return 2
    if sys.argv[1] == "--self-test":
        return self_test()
    return check_tree(pathlib.Path(sys.argv[1]))


if __name__ == "__main__":
    sys.exit(main())
