"""Whether the elements of an HTML page are closed in the order in which they must be."""

import html.parser


class _Nesting(html.parser.HTMLParser):
    def __init__(self) -> None:
        super().__init__()
        self.open: list[str] = []

    def handle_starttag(self, tag, attributes):
        if tag not in ("img", "meta", "wbr"):
            self.open.append(tag)

    def handle_endtag(self, tag):
        assert self.open.pop() == tag


def check_nesting(text: str) -> None:
    """Fail where an element of the page is closed out of turn, or not at all."""
    parser = _Nesting()
    parser.feed(text)
    assert parser.open == []
