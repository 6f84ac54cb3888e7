# The same locked packages as `make run`, without the tools that installed them.
FROM python:3.13-slim AS build
ENV PIP_DISABLE_PIP_VERSION_CHECK=1 PIP_NO_CACHE_DIR=1 PIP_ROOT_USER_ACTION=ignore
WORKDIR /src
RUN python -m venv /opt/tapeline
COPY requirements.lock .
RUN /opt/tapeline/bin/pip install --require-hashes --requirement requirements.lock
COPY pyproject.toml README.md LICENSE ./
COPY core core
COPY service service
RUN /opt/tapeline/bin/pip install --no-index --no-build-isolation --no-deps . \
 && /opt/tapeline/bin/pip uninstall --yes setuptools pip \
 && find /opt/tapeline -type d -name tests -prune -exec rm -rf {} +

FROM python:3.13-slim
# Compiled kernels and font lists lie outside the data directory: a volume over that does not hide them.
ENV PATH=/opt/tapeline/bin:$PATH \
    PYTHONUNBUFFERED=1 \
    NUMBA_CACHE_DIR=/var/cache/tapeline/numba \
    MPLCONFIGDIR=/var/cache/tapeline/matplotlib \
    TAPELINE_DATA_DIR=/var/lib/tapeline \
    TAPELINE_HOST=0.0.0.0 \
    TAPELINE_PORT=8000
RUN useradd --system --uid 10001 --no-create-home --shell /usr/sbin/nologin tapeline \
 && install --directory --owner=tapeline /var/cache/tapeline /var/lib/tapeline
COPY --from=build /opt/tapeline /opt/tapeline
USER 10001
WORKDIR /var/lib/tapeline
# Compile now what every start would compile; on a processor of another kind the first start does it again.
RUN python -c "from service.processes import PROCESSES; from service.work.tasks import warm; warm(PROCESSES)"
VOLUME /var/lib/tapeline
EXPOSE 8000
HEALTHCHECK --interval=30s --timeout=5s --start-period=60s CMD ["python", "-c", \
    "import os, urllib.request as u; u.urlopen(f'http://127.0.0.1:{os.environ[\"TAPELINE_PORT\"]}/healthz', timeout=4)"]
CMD ["python", "-m", "service"]
