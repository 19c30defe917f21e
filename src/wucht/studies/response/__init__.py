"""The study ``response``: its question and the function that answers it."""

from wucht.studies.response.study import Response, response

__all__ = ["Response", "response"]
