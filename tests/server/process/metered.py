"""A server whose metrics are read over HTTP."""
import re
import urllib.request

SAMPLE = re.compile(r'^([a-z_]+)(?:\{(.*)\})? (\S+)$')


def read(url, tls=None):
    """{(name, (label, value), ...): value} of every sample; `tls`: an ssl.SSLContext."""
    samples = {}
    with urllib.request.urlopen(url, timeout=60, context=tls) as page:
        for line in page.read().decode().splitlines():
            if line and not line.startswith("#"):
                name, labels, value = SAMPLE.match(line).groups()
                pairs = tuple(sorted(re.findall(r'(\w+)="([^"]*)"', labels or "")))
                samples[(name, *pairs)] = float(value)
    return samples


class Metered:
    """A server with metrics; `url` is where."""

    def __init__(self, process):
        self.process, self.address = process, process.address
        line = process.child.stdout.readline()
        assert line.startswith("metrics at http"), line
        self.url = line.split()[-1]

    def value(self, name, **labels):
        return read(self.url).get((name, *sorted(labels.items())))
