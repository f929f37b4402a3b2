"""A page read by the standard library's parser, strict about what must be closed."""

from dataclasses import dataclass, field
from html.parser import HTMLParser

VOID = {"meta", "link", "img", "br", "hr"}


@dataclass
class Element:
    tag: str
    attributes: dict[str, str | None]
    content: list["Element | str"] = field(default_factory=list)

    @property
    def inside(self) -> list["Element"]:
        """The elements directly below this one."""
        return [child for child in self.content if isinstance(child, Element)]

    def all(self, tag: str) -> list["Element"]:
        """Return every element of a kind below this one, in order."""
        return [found for child in self.inside for found in ([child] if child.tag == tag else []) + child.all(tag)]

    def words(self) -> str:
        """Return all text below, with single spaces."""
        return " ".join("".join(child if isinstance(child, str) else child.words() for child in self._spaced()).split())

    def _spaced(self) -> list["Element | str"]:
        inline = {"b", "a", "span"}
        return [
            part
            for child in self.content
            for part in ([child] if isinstance(child, str) or child.tag in inline else [" ", child, " "])
        ]


class Page(HTMLParser):
    """A page as a tree; an element closed out of turn or never fails."""

    def __init__(self, content: str) -> None:
        super().__init__()
        self.root = Element("root", {})
        self._open = [self.root]
        self.feed(content)
        self.close()
        assert self._open == [self.root], [element.tag for element in self._open]

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        element = Element(tag, dict(attrs))
        assert len(element.attributes) == len(attrs), f"an attribute of <{tag}> stands twice"
        self._open[-1].content.append(element)
        if tag not in VOID:
            self._open.append(element)

    def handle_endtag(self, tag: str) -> None:
        assert self._open.pop().tag == tag

    def handle_data(self, data: str) -> None:
        self._open[-1].content.append(data)
